// Nurbs vase: a turned vase with a free wall
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: nurbs_vase.ply.
// Written by partscribe 0.1.0.

use <partscribe.scad>

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Vase] */
// radius of the foot [mm]
foot_radius = as_designed ? 20 : 20.002;  // fitted 20.002 +/- 0.004 from 4,120 points; nominal 20 (0.5 mm grid, z = -0.5)
// height of the vase [mm]
height = as_designed ? 70 : 70.01;        // fitted 70.01 +/- 0.008 from 4,120 points; nominal 70 (0.5 mm grid, z = -1.3)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

// Control points of the wall.
vase_profile_wall = [
  [foot_radius, 0],
  [31.5, 12],
  [27.25, 30],
  [9.5, 44],
  [12.75, 60],
  [17, height]
];

module vase_profile()
  polygon([
    [0, 0],      // foot
    // wall, then rim
    each nurbs_curve(3, [0, 0, 0, 0, 0.4, 0.7, 1, 1, 1, 1], vase_profile_wall, weights = [1, 1, 1.2, 0.9, 1, 1], error = chord_error / 2),
    [0, height]  // axis
  ]);

module vase() {
  n = facets(max([for (p = vase_profile_wall) p.x]));
  rotate_extrude($fn = n) scale([straddled(1, n), 1]) vase_profile();
}

// From the part's own frame to the scan's.
module scan_from_part() translate([12.5, -3.25, 40]) rotate([30, -20, 75]) children();

// Number of facets around a circle of radius r; a multiple of 4, so that corners lie on the axes.
// Half of chord_error is spent around, half along a profile.
function facets(r) = 4 * ceil(22.5 / atan(sqrt(chord_error / 2 / max(r, chord_error))));

// Radius of a polygon with n corners that is as far outside a circle of radius r as inside.
function straddled(r, n) = 2 * r / (1 + cos(180 / n));

module part() vase();

if (as_scanned) scan_from_part() part();
else part();
