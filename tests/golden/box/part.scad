// Box: a rectangular block
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: box.ply.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Block] */
// size along x [mm]
width = as_designed ? 60 : 60.012;  // fitted 60.012 +/- 0.008 from 4,120 points; nominal 60 (0.5 mm grid, z = -1.5)
// size along y [mm]
depth = as_designed ? 40 : 39.991;  // fitted 39.991 +/- 0.007 from 4,120 points; nominal 40 (0.5 mm grid, z = 1.3)
// size along z [mm]
height = 25.3;                      // fitted 25.3 +/- 0.006 from 4,120 points

assert(width > 0, "width must be positive");
assert(depth > 0, "depth must be positive");
assert(height > 0, "height must be positive");

module block()
  cube([width, depth, height]);

// From the part's own frame to the scan's.
module scan_from_part() translate([12.5, -3.25, 40]) rotate([30, -20, 75]) children();

module part() block();

if (as_scanned) scan_from_part() part();
else part();
