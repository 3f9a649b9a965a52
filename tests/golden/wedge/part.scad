// Wedge: a block with one sloped face
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: wedge.ply.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Ramp] */
// size along x at the foot [mm]
length = as_designed ? 50 : 50.004;      // fitted 50.004 +/- 0.009 from 4,120 points; nominal 50 (0.5 mm grid, z = -0.4)
// size along y [mm]
depth = as_designed ? 30 : 30.002;       // fitted 30.002 +/- 0.009 from 4,120 points; nominal 30 (0.5 mm grid, z = -0.2)
// size along z [mm]
height = as_designed ? 20 : 19.997;      // fitted 19.997 +/- 0.009 from 4,120 points; nominal 20 (0.5 mm grid, z = 0.3)
// size along x at the far side [mm]
top_length = as_designed ? 15 : 15.011;  // fitted 15.011 +/- 0.01 from 4,120 points; nominal 15 (0.5 mm grid, z = -0.9)

assert(length > 0, "length must be positive");
assert(depth > 0, "depth must be positive");
assert(height > 0, "height must be positive");
assert(top_length >= 0, "top_length must not be negative");

module ramp()
  linear_extrude(height = height)
    polygon([[0, 0], [length, 0], [top_length, depth], [0, depth]]);

// From the part's own frame to the scan's.
module scan_from_part() translate([12.5, -3.25, 40]) rotate([30, -20, 75]) children();

module part() ramp();

if (as_scanned) scan_from_part() part();
else part();
