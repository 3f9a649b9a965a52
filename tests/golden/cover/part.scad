// Cover: a moulded cover with leaning walls, a dome for a screw and its hole
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: cover.ply.
// Written by partscribe 0.1.0.

use <partscribe.scad>

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Outside] */
// size along x at the foot [mm]
length = as_designed ? 80 : 80.01;   // fitted 80.01 +/- 0.01 from 4,120 points; nominal 80 (0.5 mm grid, z = -1)
// size along y at the foot [mm]
width = as_designed ? 50 : 49.995;   // fitted 49.995 +/- 0.01 from 4,120 points; nominal 50 (0.5 mm grid, z = 0.5)
// size along z [mm]
height = as_designed ? 18 : 18.002;  // fitted 18.002 +/- 0.006 from 4,120 points; nominal 18 (0.5 mm grid, z = -0.3)
// radius of the corners at the foot [mm]
corner_r = as_designed ? 9 : 9.004;  // fitted 9.004 +/- 0.006 from 4,120 points; nominal 9 (0.5 mm grid, z = -0.7)
// by which the walls lean [deg]
draft = 4;                           // fitted 4.01 +/- 0.02 from 1,200 points

/* [Inside] */
// thickness of the wall at the foot [mm]
wall = as_designed ? 3 : 3.003;     // fitted 3.003 +/- 0.004 from 4,120 points; nominal 3 (0.5 mm grid, z = -0.8)
// thickness under the top [mm]
floor = as_designed ? 2.5 : 2.502;  // fitted 2.502 +/- 0.004 from 4,120 points; nominal 2.5 (0.5 mm grid, z = -0.5)

/* [Dome] */
// diameter of the dome where it stands on the top [mm]
dome_d = as_designed ? 22 : 22.006;  // fitted 22.006 +/- 0.005 from 4,120 points; nominal 22 (0.5 mm grid, z = -1.2)

/* [Hole] */
// diameter of the hole [mm]
hole_d = as_designed ? 6.4 : 6.402;  // fitted 6.402 +/- 0.003 from 4,120 points; nominal 6.4 (0.5 mm grid, z = -0.7)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(corner_r > 0, "corner_r must be positive");
assert(height > 0, "height must be positive");
assert(dome_d > 0, "dome_d must be positive");
assert(corner_r - wall > 0, "corner_r - wall must be positive");
assert(height - floor > 0, "height - floor must be positive");
assert(hole_d > 0, "hole_d must be positive");
assert(floor + 7 > 0, "floor + 7 must be positive");
assert(dome_d / 2 + 2 * tan(2 * draft) > 0, "the draft is too large: the circle vanishes");
assert(dome_d / 2 - 7 * tan(2 * draft) > 0, "the draft is too large: the circle vanishes");

// The outside.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
// Loops of corners [x, y] and arcs [center, radius, from, to] at z = 0; the walls lean inwards by the draft.
module outside()
  drafted([
    [  // outside
      [[corner_r - length / 2, corner_r - width / 2], corner_r, 180, 270],  // corner 1, then front
      [[length / 2 - corner_r, corner_r - width / 2], corner_r, 270, 360],  // corner 2, then right
      [[length / 2 - corner_r, width / 2 - corner_r], corner_r, 0, 90],     // corner 3, then back
      [[corner_r - length / 2, width / 2 - corner_r], corner_r, 90, 180]    // corner 4, then left
    ]
  ], height = height, draft = draft, chord_error = chord_error);

// Dome for the screw.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module dome() {
  n = facets(dome_d / 2 + 2 * tan(2 * draft));
  translate([0, 0, height])
    translate([0, 0, -2]) cylinder(h = 9, $fn = n,
      r1 = straddled(dome_d / 2 + 2 * tan(2 * draft), n), r2 = straddled(dome_d / 2 - 7 * tan(2 * draft), n));
}

// Outside and dome.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module body() union() {
  outside();
  dome();
}

// The inside, around a post.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
// Loops of corners [x, y] and arcs [center, radius, from, to] at z = 0; the walls lean inwards by the draft.
module inside()
  rotate([180, 0, 0])
    drafted([
      [  // inside
        // corner 1, then front
        [[corner_r - length / 2, corner_r - width / 2], corner_r - wall, 180, 270],
        // corner 2, then right
        [[length / 2 - corner_r, corner_r - width / 2], corner_r - wall, 270, 360],
        // corner 3, then back
        [[length / 2 - corner_r, width / 2 - corner_r], corner_r - wall, 0, 90],
        // corner 4, then left
        [[corner_r - length / 2, width / 2 - corner_r], corner_r - wall, 90, 180]
      ],
      [[[-25, 0], 5, 360, 0]]  // post
    ], height = 1, below = height - floor, draft = -draft, chord_error = chord_error);

// Hole for the screw.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module hole()
  translate([0, 0, height + 7])
    round_cutter(d = hole_d, from = -(floor + 7) - 1, to = 1);

module cover() difference() {
  body();
  inside();
  hole();
}

// From the part's own frame to the scan's.
module scan_from_part() translate([12.5, -3.25, 40]) rotate([30, -20, 75]) children();

// Number of facets around a circle of radius r; a multiple of 4, so that corners lie on the axes.
// Half of chord_error is spent around, half along a profile.
function facets(r) = 4 * ceil(22.5 / atan(sqrt(chord_error / 2 / max(r, chord_error))));

// Radius of a polygon with n corners that is as far outside a circle of radius r as inside.
function straddled(r, n) = 2 * r / (1 + cos(180 / n));

// A round cutter about z.
module round_cutter(d, from, to) {
  n = facets(d / 2);
  translate([0, 0, from]) cylinder(r = straddled(d / 2, n), h = to - from, $fn = n);
}

module part() cover();

if (as_scanned) scan_from_part() part();
else part();
