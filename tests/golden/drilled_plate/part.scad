// Drilled plate: a plate with a bore and a grid of counterbored holes
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: drilled_plate.ply.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Slab] */
// size along x [mm]
length = as_designed ? 120 : 120.02;    // fitted 120.02 +/- 0.01 from 4,120 points; nominal 120 (0.5 mm grid, z = -2)
// size along y [mm]
width = as_designed ? 80 : 79.99;       // fitted 79.99 +/- 0.01 from 4,120 points; nominal 80 (0.5 mm grid, z = 1)
// size along z [mm]
thickness = as_designed ? 20 : 20.004;  // fitted 20.004 +/- 0.005 from 4,120 points; nominal 20 (0.5 mm grid, z = -0.8)

/* [Bore] */
// diameter of the bore in the middle [mm]
bore_d = as_designed ? 40 : 40.006;  // fitted 40.006 +/- 0.004 from 4,120 points; nominal 40 (0.5 mm grid, z = -1.5)

/* [Hole] */
// diameter of the holes [mm]
hole_d = as_designed ? 9 : 8.997;     // fitted 8.997 +/- 0.003 from 4,120 points; nominal 9 (0.5 mm grid, z = 1)
// diameter of the counterbores [mm]
head_d = as_designed ? 15 : 15.003;   // fitted 15.003 +/- 0.004 from 4,120 points; nominal 15 (0.5 mm grid, z = -0.8)
// depth of the counterbores [mm]
head_depth = 8.6;                     // fitted 8.6 +/- 0.004 from 4,120 points
// distance of the holes along x [mm]
pitch_x = as_designed ? 90 : 90.004;  // fitted 90.004 +/- 0.003 from 4,120 points; nominal 90 (0.5 mm grid, z = -1.3)
// distance of the holes along y [mm]
pitch_y = as_designed ? 50 : 49.998;  // fitted 49.998 +/- 0.003 from 4,120 points; nominal 50 (0.5 mm grid, z = 0.7)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(length > 0, "length must be positive");
assert(width > 0, "width must be positive");
assert(thickness > 0, "thickness must be positive");
assert(bore_d > 0, "bore_d must be positive");
assert(hole_d > 0, "hole_d must be positive");
assert(head_d >= 0, "head_d must not be negative");
assert(head_depth >= 0, "head_depth must not be negative");

// The plate.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module slab()
  translate([-length / 2, -width / 2, 0])
    cube([length, width, thickness]);

// Bore in the middle.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module bore()
  translate([0, 0, thickness])
    round_cutter(d = bore_d, from = -thickness - 1, to = 1);

// Hole for a screw.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module hole_profile()
  polygon([
    [0, -(thickness + 1)],           // far end
    [hole_d / 2, -(thickness + 1)],  // wall
    [hole_d / 2, -head_depth],       // counterbore floor
    [head_d / 2, -head_depth],       // counterbore
    [head_d / 2, 1],                 // mouth
    [0, 1]                           // axis
  ]);

module hole() {
  n = facets(head_d / 2);
  translate([-pitch_x / 2, -pitch_y / 2, thickness])
    rotate_extrude($fn = n) scale([straddled(1, n), 1]) hole_profile();
}

// Holes along x.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module row()
  for (i = [0 : 1]) translate([i * pitch_x, 0, 0]) hole();

// All four holes.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module holes()
  for (i = [0 : 1]) translate([0, i * pitch_y, 0]) row();

module plate() difference() {
  slab();
  bore();
  holes();
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

module part() plate();

if (as_scanned) scan_from_part() part();
else part();
