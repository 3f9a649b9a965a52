// Flange: a flange with a hub and a circle of countersunk holes
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: flange.ply.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Disc] */
// diameter of the flange [mm]
flange_d = as_designed ? 100 : 100.01;  // fitted 100.01 +/- 0.006 from 4,120 points; nominal 100 (0.5 mm grid, z = -1.7)
// thickness of the flange [mm]
thickness = as_designed ? 12 : 12.003;  // fitted 12.003 +/- 0.005 from 4,120 points; nominal 12 (0.5 mm grid, z = -0.6)

/* [Hub] */
// diameter of the hub [mm]
hub_d = as_designed ? 50 : 49.996;       // fitted 49.996 +/- 0.006 from 4,120 points; nominal 50 (0.5 mm grid, z = 0.7)
// how far the hub stands out [mm]
hub_height = as_designed ? 18 : 18.002;  // fitted 18.002 +/- 0.007 from 4,120 points; nominal 18 (0.5 mm grid, z = -0.3)

/* [Bore] */
// diameter of the bore [mm]
bore_d = as_designed ? 30 : 30.002;  // fitted 30.002 +/- 0.003 from 4,120 points; nominal 30 (0.5 mm grid, z = -0.7)

/* [Bolt hole] */
// diameter of the bolt circle [mm]
bolt_circle_d = as_designed ? 76 : 76.005;  // fitted 76.005 +/- 0.004 from 4,120 points; nominal 76 (0.5 mm grid, z = -1.2)
// diameter of the bolt holes [mm]
bolt_d = as_designed ? 6.6 : 6.598;         // fitted 6.598 +/- 0.002 from 4,120 points; nominal 6.6 (0.5 mm grid, z = 1)
// diameter of the countersinks [mm]
sink_d = as_designed ? 13 : 13.004;         // fitted 13.004 +/- 0.004 from 4,120 points; nominal 13 (0.5 mm grid, z = -1)
// radius of the bolt circle [mm]
bolt_circle_r = bolt_circle_d / 2;

/* [Bolt holes] */
// number of bolt holes
bolts = 6;
// from each bolt hole to the next [deg]
bolt_step = 360 / bolts;

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(flange_d > 0, "flange_d must be positive");
assert(thickness > 0, "thickness must be positive");
assert(hub_d > 0, "hub_d must be positive");
assert(hub_height > 0, "hub_height must be positive");
assert(bore_d > 0, "bore_d must be positive");
assert(thickness + hub_height > 0, "thickness + hub_height must be positive");
assert(bolt_d > 0, "bolt_d must be positive");
assert(sink_d >= 0, "sink_d must not be negative");
assert(bolts >= 1 && bolts == floor(bolts), "bolts must be a whole number");

// The flange.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module disc_body() {
  n = facets(flange_d / 2);
  cylinder(r = straddled(flange_d / 2, n), h = thickness, $fn = n);
}

// The hub.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module hub_outline()
  disc(hub_d / 2);

module hub()
  translate([0, 0, thickness])
    translate([0, 0, -2]) linear_extrude(height = 2 + hub_height) hub_outline();

// Flange and hub.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module body() union() {
  disc_body();
  hub();
}

// Bore for the shaft.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module bore()
  translate([0, 0, thickness + hub_height])
    round_cutter(d = bore_d, from = -(thickness + hub_height) - 1, to = 1);

// Bolt hole.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module bolt_hole_profile()
  polygon([
    [0, -(thickness + 1)],                   // far end
    [bolt_d / 2, -(thickness + 1)],          // wall
    [bolt_d / 2, -((sink_d - bolt_d) / 2)],  // countersink
    [sink_d / 2, 0],                         // rim
    [sink_d / 2, 1],                         // mouth
    [0, 1]                                   // axis
  ]);

module bolt_hole() {
  n = facets(sink_d / 2);
  translate([bolt_circle_r, 0, thickness])
    rotate_extrude($fn = n) scale([straddled(1, n), 1]) bolt_hole_profile();
}

// All bolt holes.
// Fit: rms 0.021 mm from 3,100 points, local mean within 0.043 mm, 87 % of its surface scanned.
module bolt_holes()
  for (i = [0 : bolts - 1]) rotate([0, 0, i * bolt_step]) bolt_hole();

module flange() difference() {
  body();
  bore();
  bolt_holes();
}

// From the part's own frame to the scan's.
module scan_from_part() translate([12.5, -3.25, 40]) rotate([30, -20, 75]) children();

// Number of facets around a circle of radius r; a multiple of 4, so that corners lie on the axes.
// Half of chord_error is spent around, half along a profile.
function facets(r) = 4 * ceil(22.5 / atan(sqrt(chord_error / 2 / max(r, chord_error))));

// Radius of a polygon with n corners that is as far outside a circle of radius r as inside.
function straddled(r, n) = 2 * r / (1 + cos(180 / n));

module disc(r) {
  n = facets(r);
  circle(r = straddled(r, n), $fn = n);
}

// A round cutter about z.
module round_cutter(d, from, to) {
  n = facets(d / 2);
  translate([0, 0, from]) cylinder(r = straddled(d / 2, n), h = to - from, $fn = n);
}

module part() flange();

if (as_scanned) scan_from_part() part();
else part();
