// Tray: a block with a pocket around an island, two lugs, slots and a blind hole
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: tray.ply.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Block] */
// size along x [mm]
length = as_designed ? 90 : 90.01;   // fitted 90.01 +/- 0.01 from 4,120 points; nominal 90 (0.5 mm grid, z = -1)
// size along y [mm]
width = as_designed ? 60 : 60.01;    // fitted 60.01 +/- 0.01 from 4,120 points; nominal 60 (0.5 mm grid, z = -1)
// size along z [mm]
height = as_designed ? 20 : 20.002;  // fitted 20.002 +/- 0.006 from 4,120 points; nominal 20 (0.5 mm grid, z = -0.3)

/* [Pocket] */
// thickness of the wall [mm]
wall = as_designed ? 6 : 6.004;        // fitted 6.004 +/- 0.004 from 4,120 points; nominal 6 (0.5 mm grid, z = -1)
// depth of the pocket [mm]
depth = as_designed ? 12 : 12.003;     // fitted 12.003 +/- 0.004 from 4,120 points; nominal 12 (0.5 mm grid, z = -0.8)
// diameter of the island [mm]
island_d = as_designed ? 24 : 23.996;  // fitted 23.996 +/- 0.005 from 4,120 points; nominal 24 (0.5 mm grid, z = 0.8)

/* [Drill] */
// diameter of the blind hole [mm]
drill_d = as_designed ? 10 : 10.002;  // fitted 10.002 +/- 0.004 from 4,120 points; nominal 10 (0.5 mm grid, z = -0.5)

/* [Slot] */
// length of the slots [mm]
slot_length = as_designed ? 14 : 14.003;  // fitted 14.003 +/- 0.005 from 4,120 points; nominal 14 (0.5 mm grid, z = -0.6)
// width of the slots [mm]
slot_width = as_designed ? 6 : 6.002;     // fitted 6.002 +/- 0.004 from 4,120 points; nominal 6 (0.5 mm grid, z = -0.5)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(height > 0, "height must be positive");
assert(island_d > 0, "island_d must be positive");
assert(depth > 0, "depth must be positive");
assert(drill_d > 0, "drill_d must be positive");
assert(slot_length > 0, "slot_length must be positive");
assert(slot_width > 0, "slot_width must be positive");
assert(slot_length > slot_width, "a slot must be longer than wide");

// The block.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module block_outline()
  polygon([
    [-(length / 2), -(width / 2)],  // front
    [length / 2, -(width / 2)],     // right
    [length / 2, width / 2],        // back
    [-(length / 2), width / 2]      // left
  ]);

module block()
  linear_extrude(height = height) block_outline();

// The pocket.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module pocket_outline() difference() {
  polygon([
    [wall - length / 2, wall - width / 2],  // front
    [length / 2 - wall, wall - width / 2],  // right
    [length / 2 - wall, width / 2 - wall],  // back
    [wall - length / 2, width / 2 - wall]   // left
  ]);  // wall
  disc(island_d / 2);  // island
}

module pocket()
  translate([0, 0, height])
    translate([0, 0, -depth]) linear_extrude(height = depth + 1) pocket_outline();

// Blind hole in the island.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module drill_profile()
  polygon([
    [0, -9 - drill_d / 2 * cos(59) / sin(59)],  // tip
    [drill_d / 2, -9],                          // wall
    [drill_d / 2, 1],                           // mouth
    [0, 1]                                      // axis
  ]);

module drill() {
  n = facets(drill_d / 2);
  translate([0, 0, height])
    rotate_extrude($fn = n) scale([straddled(1, n), 1]) drill_profile();
}

// Lug on the right.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module lug_outline()
  polygon([
    [length / 2 - 2, -10],                        // front
    each arc([length / 2 + 10, 0], 10, -90, 90),  // end, then back
    [length / 2 - 2, 10]
  ]);

module lug()
  linear_extrude(height = 8) lug_outline();

// Both lugs.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module lugs() {
  lug();
  mirror([1, 0, 0]) lug();
}

// Slot in the right lug.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module slot()
  translate([length / 2 + 10, 0, 8]) rotate([0, 0, 90])
    translate([0, 0, -9]) linear_extrude(height = 10)
    hull() {
      translate([-((slot_length - slot_width) / 2), 0]) disc(slot_width / 2);
      translate([(slot_length - slot_width) / 2, 0]) disc(slot_width / 2);
    }

// Both slots.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module slots() {
  slot();
  mirror([1, 0, 0]) slot();
}

// Block and lugs.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module body() union() {
  block();
  lugs();
}

module tray() difference() {
  body();
  pocket();
  drill();
  slots();
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

module disc(r) {
  n = facets(r);
  circle(r = straddled(r, n), $fn = n);
}

module part() tray();

if (as_scanned) scan_from_part() part();
else part();
