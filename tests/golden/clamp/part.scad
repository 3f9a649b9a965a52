// Clamp: an angle with a filled inner edge, a rounded and a chamfered outer one, and a bore
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: clamp.ply.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Foot] */
// length of the foot [mm]
length = as_designed ? 50 : 50.01;    // fitted 50.01 +/- 0.008 from 4,120 points; nominal 50 (0.5 mm grid, z = -1.2)
// width of foot and wall [mm]
width = as_designed ? 30 : 29.994;    // fitted 29.994 +/- 0.006 from 4,120 points; nominal 30 (0.5 mm grid, z = 1)
// thickness of foot and wall [mm]
thickness = as_designed ? 9 : 9.003;  // fitted 9.003 +/- 0.004 from 4,120 points; nominal 9 (0.5 mm grid, z = -0.8)

/* [Wall] */
// height of the wall [mm]
height = as_designed ? 36 : 36.004;  // fitted 36.004 +/- 0.007 from 4,120 points; nominal 36 (0.5 mm grid, z = -0.6)

/* [Inner edge tool] */
// radius of the inner edge [mm]
inner_r = as_designed ? 6 : 6.004;  // fitted 6.004 +/- 0.01 from 4,120 points; nominal 6 (0.5 mm grid, z = -0.4)

/* [Outer edge tool] */
// radius of the wall's upper edge [mm]
outer_r = as_designed ? 5 : 4.996;  // fitted 4.996 +/- 0.01 from 4,120 points; nominal 5 (0.5 mm grid, z = 0.4)

/* [Front edge tool] */
// legs of the chamfers [mm]
chamfer = as_designed ? 1.5 : 1.503;  // fitted 1.503 +/- 0.01 from 4,120 points; nominal 1.5 (0.5 mm grid, z = -0.3)

/* [Bore] */
// diameter of the bore [mm]
bore_d = as_designed ? 11 : 11.003;  // fitted 11.003 +/- 0.004 from 4,120 points; nominal 11 (0.5 mm grid, z = -0.8)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(length > 0, "length must be positive");
assert(width > 0, "width must be positive");
assert(thickness > 0, "thickness must be positive");
assert(height > 0, "height must be positive");
assert(inner_r > 0, "inner_r must be positive");
assert(outer_r > 0, "outer_r must be positive");
assert(chamfer > 0, "chamfer must be positive");
assert(bore_d > 0, "bore_d must be positive");

// The foot.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module foot()
  cube([length, width, thickness]);

// The wall.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module wall()
  cube([thickness, width, height]);

// Foot and wall.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module angle() union() {
  foot();
  wall();
}

module inner_edge_tool_outline()
  polygon([
    [inner_r, -1],
    each arc([inner_r, inner_r], inner_r, 270, 180),  // fillet
    [-1, inner_r],
    [-1, -1]
  ]);

module inner_edge_tool()
  translate([thickness, 0, thickness]) rotate([0, -90, -90])
    linear_extrude(height = width) inner_edge_tool_outline();

// With the inner edge filled.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module inner_edge() union() {
  angle();
  inner_edge_tool();
}

module outer_edge_tool_outline()
  polygon([
    [1, -1],
    [1, outer_r],
    each arc([-outer_r, outer_r], outer_r, 0, -90),  // fillet
    [-outer_r, -1]
  ]);

module outer_edge_tool()
  translate([0, -1, height]) rotate([0, -90, -90])
    linear_extrude(height = width + 1 + 1) outer_edge_tool_outline();

// With the upper edge rounded.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module outer_edge() difference() {
  inner_edge();
  outer_edge_tool();
}

module front_edge_tool_outline()
  polygon([
    [-chamfer, 1],
    [-chamfer, 0],  // chamfer
    [0, -chamfer],
    [1, -chamfer],
    [1, 1]
  ]);

module front_edge_tool()
  translate([length, -1, thickness]) rotate([0, -90, -90])
    linear_extrude(height = width + 1 + 1) front_edge_tool_outline();

// With the front edge chamfered.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module front_edge() difference() {
  outer_edge();
  front_edge_tool();
}

// The bore.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module bore()
  translate([(length + thickness + inner_r) / 2, width / 2, thickness])
    round_cutter(d = bore_d, from = -thickness - 1, to = 1);

// With the bore.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module drilled() difference() {
  front_edge();
  bore();
}

module clamp_tool_profile()
  polygon([
    [bore_d / 2 - 1, -chamfer],
    [bore_d / 2, -chamfer],  // chamfer
    [bore_d / 2 + chamfer, 0],
    [bore_d / 2 + chamfer, 1],
    [bore_d / 2 - 1, 1]
  ]);

module clamp_tool() {
  n = facets(bore_d / 2 + chamfer);
  translate([(length + thickness + inner_r) / 2, width / 2, thickness])
    rotate_extrude($fn = n) scale([straddled(1, n), 1]) clamp_tool_profile();
}

module clamp() difference() {
  drilled();
  clamp_tool();
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

// A round cutter about z.
module round_cutter(d, from, to) {
  n = facets(d / 2);
  translate([0, 0, from]) cylinder(r = straddled(d / 2, n), h = to - from, $fn = n);
}

module part() clamp();

if (as_scanned) scan_from_part() part();
else part();
