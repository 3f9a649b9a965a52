// Fillet: what rounds an inner corner
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: fillet.ply.
// Written by partscribe 0.1.0.

use <partscribe.scad>

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Fillet strip] */
// first leg [mm]
width = as_designed ? 14 : 14.003;  // fitted 14.003 +/- 0.005 from 4,120 points; nominal 14 (0.5 mm grid, z = -0.6)
// second leg [mm]
height = as_designed ? 10 : 9.998;  // fitted 9.998 +/- 0.005 from 4,120 points; nominal 10 (0.5 mm grid, z = 0.4)
// length of the strip [mm]
length = as_designed ? 50 : 50.01;  // fitted 50.01 +/- 0.006 from 4,120 points; nominal 50 (0.5 mm grid, z = -1.7)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(width > 0, "width must be positive");
assert(height > 0, "height must be positive");
assert(length > 0, "length must be positive");

// Control points of the fillet.
fillet_strip_outline_fillet = [
  [width, 0],
  [0, 0],
  [0, height]
];

module fillet_strip_outline()
  polygon([
    [0, 0],  // base
    // fillet, then wall
    each nurbs_curve(2, [0, 0, 0, 1, 1, 1], fillet_strip_outline_fillet, weights = [1, 0.7071067811865476, 1], error = chord_error / 2)
  ]);

module fillet_strip()
  linear_extrude(height = length) fillet_strip_outline();

// From the part's own frame to the scan's.
module scan_from_part() translate([12.5, -3.25, 40]) rotate([30, -20, 75]) children();

module part() fillet_strip();

if (as_scanned) scan_from_part() part();
else part();
