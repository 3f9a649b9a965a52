// Half spaces: a block with a cut corner
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: half_spaces.ply.
// Written by partscribe 0.1.0.

use <partscribe.scad>

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Cut block] */
// distance of the sides from the middle [mm]
half_width = as_designed ? 20 : 20.003;         // fitted 20.003 +/- 0.004 from 4,120 points; nominal 20 (0.5 mm grid, z = -0.8)
// distance of the top from the bottom [mm]
height = as_designed ? 30 : 29.995;             // fitted 29.995 +/- 0.006 from 4,120 points; nominal 30 (0.5 mm grid, z = 0.8)
// distance of the cut corner from the origin [mm]
corner_distance = as_designed ? 32.5 : 32.499;  // fitted 32.499 +/- 0.008 from 4,120 points; nominal 32.5 (0.5 mm grid, z = 0.1)

// Each face by its outward normal and its distance from the origin.
module cut_block()
  half_spaces([
    [[1, 0, 0], half_width],                                                         // right
    [[-1, 0, 0], half_width],                                                        // left
    [[0, 1, 0], half_width],                                                         // back
    [[0, -1, 0], half_width],                                                        // front
    [[0, 0, 1], height],                                                             // top
    [[0, 0, -1], 0],                                                                 // bottom
    [[0.6666666666666666, 0.3333333333333333, 0.6666666666666666], corner_distance]  // cut corner
  ]);

// From the part's own frame to the scan's.
module scan_from_part() translate([12.5, -3.25, 40]) rotate([30, -20, 75]) children();

module part() cut_block();

if (as_scanned) scan_from_part() part();
else part();
