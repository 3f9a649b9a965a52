// Elbow: a quarter of a tube between two flats
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: elbow.ply.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Elbow] */
// radius of the tube's centre line [mm]
bend_radius = as_designed ? 40 : 40.01;  // fitted 40.01 +/- 0.008 from 4,120 points; nominal 40 (0.5 mm grid, z = -1.2)
// diameter of the tube [mm]
outer_d = as_designed ? 24 : 24.003;     // fitted 24.003 +/- 0.004 from 4,120 points; nominal 24 (0.5 mm grid, z = -0.8)
// diameter of the bore [mm]
inner_d = as_designed ? 18 : 17.998;     // fitted 17.998 +/- 0.004 from 4,120 points; nominal 18 (0.5 mm grid, z = 0.5)
// how far the tube turns [deg]
bend = 75;                               // fitted 75.01 +/- 0.02 from 1,200 points

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(outer_d > 0, "outer_d must be positive");
assert(inner_d > 0, "inner_d must be positive");
assert(bend > 0 && bend <= 360, "bend must lie in 0 .. 360");

module elbow_profile() difference() {
  translate([bend_radius, 0]) disc(outer_d / 2);  // outside
  translate([bend_radius, 0]) disc(inner_d / 2);  // bore
}

module elbow() {
  n = facets(bend_radius + outer_d / 2);
  rotate_extrude(angle = bend, $fn = n) scale([straddled(1, n), 1]) elbow_profile();
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

module part() elbow();

if (as_scanned) scan_from_part() part();
else part();
