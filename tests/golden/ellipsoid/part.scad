// Ellipsoid: an egg with three axes
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: ellipsoid.ply.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Egg] */
// half axis along x [mm]
half_length = as_designed ? 30 : 30.01;  // fitted 30.01 +/- 0.006 from 4,120 points; nominal 30 (0.5 mm grid, z = -1.7)
// half axis along y [mm]
half_width = as_designed ? 20 : 20.01;   // fitted 20.01 +/- 0.006 from 4,120 points; nominal 20 (0.5 mm grid, z = -1.7)
// half axis along z [mm]
half_height = as_designed ? 12 : 12.01;  // fitted 12.01 +/- 0.006 from 4,120 points; nominal 12 (0.5 mm grid, z = -1.7)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(half_length > 0, "half_length must be positive");
assert(half_width > 0, "half_width must be positive");
assert(half_height > 0, "half_height must be positive");

module egg() {
  longest = max(half_length, half_width, half_height);
  scale([half_length, half_width, half_height] / longest) ball(longest);
}

// From the part's own frame to the scan's.
module scan_from_part() translate([12.5, -3.25, 40]) rotate([30, -20, 75]) children();

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

module part() egg();

if (as_scanned) scan_from_part() part();
else part();
