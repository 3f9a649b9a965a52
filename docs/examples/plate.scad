// Plate
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.03 mm from 59,981 points, local mean within 0.034 mm, 100 % of its surface scanned.
// Source: scan.json, view_00.png, view_01.png, view_02.png and 5 more.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Plate] */
// length of the plate [mm]
length = 120;    // fitted 120 +/- 0.002 from 9,231 points; nominal 120 (multiples of 10 mm, z = -0.2)
// width of the plate [mm]
width = 80;      // fitted 80 +/- 0.002 from 13,035 points; nominal 80 (multiples of 10 mm, z = -0.1)
// thickness of the plate [mm]
thickness = 20;  // fitted 20 +/- 0.002 from 27,953 points; nominal 20 (multiples of 10 mm, z = 0.1)

/* [Screw hole] */
// diameter of the screw holes [mm]
screw_hole_d = 9;                     // fitted 9 +/- 0.003 from 552 points; nominal 9 (multiples of 1 mm, z = 0.1)
// diameter of the counterbore [mm]
head_d = as_designed ? 15 : 14.999;   // fitted 14.999 +/- 0.002 from 1,383 points; nominal 15 (multiples of 5 mm, z = 0.3)
// depth of the counterbore [mm]
head_depth = 8.5998;                  // fitted 8.6 +/- 0.002 from 486 points; nominal 8.6 refused (multiples of 0.1 mm, z = 0.1)
// from hole to hole along x [mm]
pitch_x = 90;                         // fitted 90 +/- 0.003 from 1,654 points; nominal 90 (multiples of 10 mm, z = -0.1)
// from hole to hole along y [mm]
pitch_y = as_designed ? 50 : 49.998;  // fitted 49.998 +/- 0.002 from 1,694 points; nominal 50 (multiples of 10 mm, z = 0.7)

/* [Bore] */
// diameter of the bore [mm]
bore_d = as_designed ? 40 : 40.002;  // fitted 40.002 +/- 0.002 from 4,316 points; nominal 40 (multiples of 10 mm, z = -1.3)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(length > 0, "length must be positive");
assert(width > 0, "width must be positive");
assert(thickness > 0, "thickness must be positive");
assert(screw_hole_d > 0, "screw_hole_d must be positive");
assert(head_d >= 0, "head_d must not be negative");
assert(head_depth >= 0, "head_depth must not be negative");
assert(bore_d > 0, "bore_d must be positive");

// The body before it is drilled.
module plate()
  translate([-(length / 2), -(width / 2), 0])
    cube([length, width, thickness]);

// One screw hole.
module screw_hole_profile()
  polygon([
    [0, -(thickness + 1)],                 // far end
    [screw_hole_d / 2, -(thickness + 1)],  // wall
    [screw_hole_d / 2, -head_depth],       // counterbore floor
    [head_d / 2, -head_depth],             // counterbore
    [head_d / 2, 1],                       // mouth
    [0, 1]                                 // axis
  ]);

module screw_hole() {
  n = facets(head_d / 2);
  translate([-(pitch_x / 2), -(pitch_y / 2), thickness])
    rotate_extrude($fn = n) scale([straddled(1, n), 1]) screw_hole_profile();
}

// Along x.
module screw_hole_row()
  for (i = [0 : 1]) translate([i * pitch_x, 0, 0]) screw_hole();

// Along y.
module screw_holes()
  for (i = [0 : 1]) translate([0, i * pitch_y, 0]) screw_hole_row();

// The bore.
module bore()
  translate([0, 0, thickness])
    round_cutter(d = bore_d, from = -thickness - 1, to = 1);

module drilled_plate() difference() {
  plate();
  screw_holes();
  bore();
}

// From the part's own frame to the scan's.
module scan_from_part() translate([12.497, -3.251, 40.001]) rotate([29.9993, -20.0006, 75.0019]) children();

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

module part() drilled_plate();

if (as_scanned) scan_from_part() part();
else part();
