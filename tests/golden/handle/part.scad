// Handle: a rounded, bent handle
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: handle.ply.
// Written by partscribe 0.1.0.

use <partscribe.scad>

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Handle] */
// half size along x [mm]
half_width = as_designed ? 8 : 8.004;    // fitted 8.004 +/- 0.005 from 4,120 points; nominal 8 (0.5 mm grid, z = -0.8)
// half size along y [mm]
half_depth = as_designed ? 11 : 10.997;  // fitted 10.997 +/- 0.005 from 4,120 points; nominal 11 (0.5 mm grid, z = 0.6)
// half size along z, before it is bent [mm]
half_length = as_designed ? 40 : 40.01;  // fitted 40.01 +/- 0.008 from 4,120 points; nominal 40 (0.5 mm grid, z = -1.2)
// by which the axis turns from the middle to each end [deg]
bend = 55;                               // fitted 55.01 +/- 0.02 from 1,200 points

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(half_width > 0, "half_width must be positive");
assert(half_depth > 0, "half_depth must be positive");
assert(half_length > 0, "half_length must be positive");

module handle()
  superellipsoid([half_width, half_depth, half_length], e1 = 0.6, e2 = 0.8, taper = [0.15, 0.1],
    bend = bend, chord_error = chord_error);

// From the part's own frame to the scan's.
module scan_from_part() translate([12.5, -3.25, 40]) rotate([30, -20, 75]) children();

module part() handle();

if (as_scanned) scan_from_part() part();
else part();
