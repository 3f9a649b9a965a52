// Cylinder: a round bar
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: cylinder.ply.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Bar] */
// radius of the bar [mm]
radius = as_designed ? 12 : 11.999;  // fitted 11.999 +/- 0.001 from 4,120 points; nominal 12 (0.5 mm grid, z = 0.9)
// length of the bar [mm]
length = as_designed ? 80 : 80.021;  // fitted 80.021 +/- 0.02 from 4,120 points; nominal 80 (0.5 mm grid, z = -1.4)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(radius > 0, "radius must be positive");
assert(length > 0, "length must be positive");

module bar() {
  n = facets(radius);
  cylinder(r = straddled(radius, n), h = length, $fn = n);
}

// From the part's own frame to the scan's.
module scan_from_part() translate([12.5, -3.25, 40]) rotate([30, -20, 75]) children();

// Number of facets around a circle of radius r; a multiple of 4, so that corners lie on the axes.
// Half of chord_error is spent around, half along a profile.
function facets(r) = 4 * ceil(22.5 / atan(sqrt(chord_error / 2 / max(r, chord_error))));

// Radius of a polygon with n corners that is as far outside a circle of radius r as inside.
function straddled(r, n) = 2 * r / (1 + cos(180 / n));

module part() bar();

if (as_scanned) scan_from_part() part();
else part();
