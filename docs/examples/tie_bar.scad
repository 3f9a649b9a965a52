// Tie bar
//
// Units: millimetres and degrees. Tolerance: 0.15 mm.
// Fit: rms 0.02 mm from 30,858 points, local mean within 0.019 mm, 100 % of its surface scanned.
// Source: scan.json, view_00.png, view_01.png, view_02.png and 5 more.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Plate] */
// radius of the round end [mm]
end_radius = 15;                          // fitted 15 +/- 0.001 from 10,049 points; nominal 15 (diameter, multiples of 10 mm, z = 0.2)
// x of the centre of the end [mm]
end_center_x = 80;                        // fitted 80 +/- 0.001 from 2,036 points; nominal 80 (multiples of 10 mm, z = 0)
// radius of the hole [mm]
hole_radius = 8;                          // fitted 8 +/- 0.001 from 791 points; nominal 8 (diameter, preferred numbers R20, z = -0.1)
// radius of the hole [mm]
hole_2_radius = as_designed ? 5 : 5.001;  // fitted 5.001 +/- 0.002 from 313 points; nominal 5 (diameter, multiples of 10 mm, z = -0.4)
// length of the extrusion [mm]
height = 12;                              // fitted 12 +/- 0.001 from 9,813 points; nominal 12 (multiples of 1 mm, z = 0.3)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.015;

assert(end_radius > 0, "end_radius must be positive");
assert(hole_radius > 0, "hole_radius must be positive");
assert(hole_2_radius > 0, "hole_2_radius must be positive");
assert(height > 0, "height must be positive");

module plate_outline() difference() {
  polygon([
    each arc([end_center_x, 0], end_radius, -90, 90),  // end, then back
    each arc([0, 0], end_radius, 90, 270)              // end, then front
  ]);  // outline
  disc(hole_radius);  // hole 1
  translate([end_center_x, 0]) disc(hole_2_radius);  // hole 2
}

module plate()
  linear_extrude(height = height) plate_outline();

// From the part's own frame to the scan's.
module scan_from_part() translate([-20, 35, 8]) rotate([-22.9169, 14.3243, 63.0247]) children();

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

module disc(r) {
  n = facets(r);
  circle(r = straddled(r, n), $fn = n);
}

module part() plate();

if (as_scanned) scan_from_part() part();
else part();
