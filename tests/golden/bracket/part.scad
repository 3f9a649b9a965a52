// Bracket: an angle bracket with bores
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: bracket.ply.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Foot] */
// width of both plates [mm]
width = as_designed ? 40 : 40.004;    // fitted 40.004 +/- 0.006 from 4,120 points; nominal 40 (0.5 mm grid, z = -0.7)
// length of the foot [mm]
length = as_designed ? 60 : 60.011;   // fitted 60.011 +/- 0.008 from 4,120 points; nominal 60 (0.5 mm grid, z = -1.4)
// thickness of both plates [mm]
thickness = as_designed ? 8 : 8.002;  // fitted 8.002 +/- 0.004 from 4,120 points; nominal 8 (0.5 mm grid, z = -0.5)

/* [Wall] */
// height of the wall [mm]
height = as_designed ? 50 : 49.996;  // fitted 49.996 +/- 0.007 from 4,120 points; nominal 50 (0.5 mm grid, z = 0.6)

/* [Bore 1] */
// radius of the bores in the foot [mm]
bore_radius = as_designed ? 4.5 : 4.499;    // fitted 4.499 +/- 0.002 from 4,120 points; nominal 4.5 (0.5 mm grid, z = 0.9)
// distance between the bores in the foot [mm]
bore_distance = as_designed ? 22 : 22.003;  // fitted 22.003 +/- 0.003 from 4,120 points; nominal 22 (0.5 mm grid, z = -1)
// by which a cut reaches out of the part [mm]
overshoot = 1;

/* [Eye] */
// radius of the eye in the wall [mm]
eye_radius = as_designed ? 9 : 9.003;  // fitted 9.003 +/- 0.002 from 4,120 points; nominal 9 (0.5 mm grid, z = -1.5)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(length > 0, "length must be positive");
assert(width > 0, "width must be positive");
assert(thickness > 0, "thickness must be positive");
assert(height > 0, "height must be positive");
assert(bore_radius > 0, "bore_radius must be positive");
assert(thickness + 2 * overshoot > 0, "thickness + 2 * overshoot must be positive");
assert(eye_radius > 0, "eye_radius must be positive");

// The plate that lies.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module foot()
  cube([length, width, thickness]);

// The plate that stands.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module wall()
  cube([thickness, width, height]);

// Both plates.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module body() union() {
  foot();
  wall();
}

// Front bore in the foot.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module bore_1() {
  n = facets(bore_radius);
  translate([length * 2 / 3, (width - bore_distance) / 2, -overshoot])
    cylinder(r = straddled(bore_radius, n), h = thickness + 2 * overshoot, $fn = n);
}

// Back bore in the foot.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module bore_2() {
  n = facets(bore_radius);
  translate([length * 2 / 3, (width + bore_distance) / 2, -overshoot])
    cylinder(r = straddled(bore_radius, n), h = thickness + 2 * overshoot, $fn = n);
}

// Eye in the wall.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module eye() {
  n = facets(eye_radius);
  translate([-overshoot, width / 2, height * 0.6]) rotate([0, 90, 0])
    cylinder(r = straddled(eye_radius, n), h = thickness + 2 * overshoot, $fn = n);
}

module bracket() difference() {
  body();
  bore_1();
  bore_2();
  eye();
}

// From the part's own frame to the scan's.
module scan_from_part() translate([12.5, -3.25, 40]) rotate([30, -20, 75]) children();

// Number of facets around a circle of radius r; a multiple of 4, so that corners lie on the axes.
// Half of chord_error is spent around, half along a profile.
function facets(r) = 4 * ceil(22.5 / atan(sqrt(chord_error / 2 / max(r, chord_error))));

// Radius of a polygon with n corners that is as far outside a circle of radius r as inside.
function straddled(r, n) = 2 * r / (1 + cos(180 / n));

module part() bracket();

if (as_scanned) scan_from_part() part();
else part();
