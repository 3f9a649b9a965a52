// Supertoroid: a rounded square ring
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: supertoroid.ply.
// Written by partscribe 0.1.0.

use <partscribe.scad>

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Gasket] */
// radius of the ring's centre line [mm]
ring_radius = as_designed ? 30 : 30.004;     // fitted 30.004 +/- 0.005 from 4,120 points; nominal 30 (0.5 mm grid, z = -0.8)
// half width of the tube [mm]
tube_half_width = as_designed ? 8 : 7.997;   // fitted 7.997 +/- 0.005 from 4,120 points; nominal 8 (0.5 mm grid, z = 0.6)
// half height of the tube [mm]
tube_half_height = as_designed ? 5 : 5.002;  // fitted 5.002 +/- 0.005 from 4,120 points; nominal 5 (0.5 mm grid, z = -0.4)
// of the ring: 0.1 square, 1 round
squareness = 0.6;                            // fitted 0.6 +/- 0.003 from 9,000 points

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(ring_radius > 0, "ring_radius must be positive");
assert(tube_half_width > 0, "tube_half_width must be positive");
assert(tube_half_height > 0, "tube_half_height must be positive");
assert(squareness >= 0.1 && squareness <= 2, "squareness must lie in 0.1 .. 2");

module gasket()
  supertoroid(ring_radius, tube_half_width, tube_half_height, e1 = 0.8, e2 = squareness,
    chord_error = chord_error);

// From the part's own frame to the scan's.
module scan_from_part() translate([12.5, -3.25, 40]) rotate([30, -20, 75]) children();

module part() gasket();

if (as_scanned) scan_from_part() part();
else part();
