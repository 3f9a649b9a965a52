// Torus: a ring
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: torus.ply.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Ring] */
// radius of the centre circle [mm]
ring_radius = as_designed ? 30 : 30.001;  // fitted 30.001 +/- 0.003 from 4,120 points; nominal 30 (0.5 mm grid, z = -0.3)
// radius of the tube [mm]
tube_radius = as_designed ? 8 : 7.999;    // fitted 7.999 +/- 0.002 from 4,120 points; nominal 8 (0.5 mm grid, z = 0.4)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(ring_radius > 0, "ring_radius must be positive");
assert(tube_radius > 0, "tube_radius must be positive");
assert(tube_radius < ring_radius, "tube_radius must be less than ring_radius");

module ring() {
  n = facets(ring_radius + tube_radius);
  rotate_extrude($fn = n) scale([straddled(1, n), 1]) translate([ring_radius, 0]) disc(tube_radius);
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

module part() ring();

if (as_scanned) scan_from_part() part();
else part();
