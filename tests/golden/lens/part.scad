// Lens: what two balls have in common, cut by a slanted groove
//
// Units: millimetres and degrees. Tolerance: 0.5 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: lens.ply.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;

/* [Front] */
// radius of the front [mm]
front_radius = as_designed ? 40 : 40.01;       // fitted 40.01 +/- 0.01 from 4,120 points; nominal 40 (0.5 mm grid, z = -1)
// thickness in the middle [mm]
center_thickness = as_designed ? 10 : 10.001;  // fitted 10.001 +/- 0.004 from 4,120 points; nominal 10 (0.5 mm grid, z = -0.2)

/* [Back] */
// radius of the back [mm]
back_radius = as_designed ? 55 : 55.02;  // fitted 55.02 +/- 0.02 from 4,120 points; nominal 55 (0.5 mm grid, z = -1)

/* [Groove] */
// of the groove [deg]
tilt = 7.5;  // fitted 7.51 +/- 0.02 from 1,200 points

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.05;

assert(front_radius > 0, "front_radius must be positive");
assert(back_radius > 0, "back_radius must be positive");

// Front ball.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module front()
  translate([0, 0, center_thickness - front_radius])
    ball(front_radius);

// Back ball.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module back()
  translate([0, 0, back_radius])
    ball(back_radius);

// What both balls share.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module blank() intersection() {
  front();
  back();
}

// Slanted groove.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module groove()
  translate([-30, -1, center_thickness - 2]) rotate([0, 0, 2 * tilt])
    cube([60, 2, 4]);

module lens() difference() {
  blank();
  groove();
}

// Number of facets around a circle of radius r; a multiple of 4, so that corners lie on the axes.
// Half of chord_error is spent around, half along a profile.
function facets(r) = 4 * ceil(22.5 / atan(sqrt(chord_error / 2 / max(r, chord_error))));

// Radius of a polygon with n corners that is as far outside a circle of radius r as inside.
function straddled(r, n) = 2 * r / (1 + cos(180 / n));

// Points on the arc about center from one angle to another, both ends included.
function arc(center, r, from, to) =
  let (step = 2 * acos(1 - chord_error / 2 / max(r, chord_error)),
       n = ceil(abs(to - from) / step))
  [for (i = [0 : n]) let (a = i == n ? to : from + (to - from) * i / n) center + r * [cos(a), sin(a)]];

// sphere() has no corners at its poles, the turned half disc does.
module ball(r) {
  n = facets(r);
  rotate_extrude($fn = n) scale([straddled(1, n), 1]) polygon(arc([0, 0], r, -90, 90));
}

module part() lens();

part();
