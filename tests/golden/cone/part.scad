// Cone: a frustum
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: cone.ply.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;

/* [Frustum] */
// radius at the foot [mm]
foot_radius = as_designed ? 20 : 20.003;  // fitted 20.003 +/- 0.004 from 4,120 points; nominal 20 (0.5 mm grid, z = -0.8)
// radius at the tip [mm]
tip_radius = as_designed ? 5 : 4.998;     // fitted 4.998 +/- 0.005 from 4,120 points; nominal 5 (0.5 mm grid, z = 0.4)
// height of the frustum [mm]
height = as_designed ? 35 : 35.006;       // fitted 35.006 +/- 0.01 from 4,120 points; nominal 35 (0.5 mm grid, z = -0.6)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(foot_radius >= 0, "foot_radius must not be negative");
assert(tip_radius >= 0, "tip_radius must not be negative");
assert(height > 0, "height must be positive");

module frustum() {
  n = facets(max(foot_radius, tip_radius));
  rotate([90, 0, 0])
    cylinder(r1 = straddled(foot_radius, n), r2 = straddled(tip_radius, n), h = height, $fn = n);
}

// Number of facets around a circle of radius r; a multiple of 4, so that corners lie on the axes.
// Half of chord_error is spent around, half along a profile.
function facets(r) = 4 * ceil(22.5 / atan(sqrt(chord_error / 2 / max(r, chord_error))));

// Radius of a polygon with n corners that is as far outside a circle of radius r as inside.
function straddled(r, n) = 2 * r / (1 + cos(180 / n));

module part() frustum();

part();
