// Superellipsoid: a rounded, tapered block
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: superellipsoid.ply.
// Written by partscribe 0.1.0.

use <partscribe.scad>

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Soap] */
// half size along x [mm]
half_length = as_designed ? 30 : 30.01;  // fitted 30.01 +/- 0.006 from 4,120 points; nominal 30 (0.5 mm grid, z = -1.7)
// half size along y [mm]
half_width = as_designed ? 20 : 20.01;   // fitted 20.01 +/- 0.006 from 4,120 points; nominal 20 (0.5 mm grid, z = -1.7)
// half size along z [mm]
half_height = as_designed ? 15 : 15.01;  // fitted 15.01 +/- 0.006 from 4,120 points; nominal 15 (0.5 mm grid, z = -1.7)
// 0: square edges, 1: round
squareness = 0.4;                        // fitted 0.4 +/- 0.003 from 9,000 points

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(half_length > 0, "half_length must be positive");
assert(half_width > 0, "half_width must be positive");
assert(half_height > 0, "half_height must be positive");
assert(squareness >= 0.1 && squareness <= 2, "squareness must lie in 0.1 .. 2");

module soap()
  superellipsoid([half_length, half_width, half_height], e1 = squareness, e2 = 0.7, taper = [-0.2, 0.15],
    chord_error = chord_error);

// From the part's own frame to the scan's.
module scan_from_part() translate([12.5, -3.25, 40]) rotate([30, -20, 75]) children();

module part() soap();

if (as_scanned) scan_from_part() part();
else part();
