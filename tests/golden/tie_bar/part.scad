// Tie bar: a link with two eyes
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: tie_bar.ply.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Tie bar] */
// distance between the axes of the eyes [mm]
eye_distance = as_designed ? 80 : 80.008;  // fitted 80.008 +/- 0.004 from 4,120 points; nominal 80 (0.5 mm grid, z = -2)
// radius of the rounded ends [mm]
end_radius = as_designed ? 15 : 14.997;    // fitted 14.997 +/- 0.003 from 4,120 points; nominal 15 (0.5 mm grid, z = 1)
// radius of both bores [mm]
bore_radius = as_designed ? 8 : 8.002;     // fitted 8.002 +/- 0.001 from 4,120 points; nominal 8 (0.5 mm grid, z = -1.9)
// thickness of the bar [mm]
thickness = as_designed ? 12 : 12.003;     // fitted 12.003 +/- 0.005 from 4,120 points; nominal 12 (0.5 mm grid, z = -0.6)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(end_radius > 0, "end_radius must be positive");
assert(bore_radius > 0, "bore_radius must be positive");
assert(thickness > 0, "thickness must be positive");

module tie_bar_outline() difference() {
  polygon([
    each arc([0, 0], end_radius, 90, 270),            // left end, then front
    each arc([eye_distance, 0], end_radius, -90, 90)  // right end, then back
  ]);  // outline
  disc(bore_radius);  // left bore
  translate([eye_distance, 0]) disc(bore_radius);  // right bore
}

module tie_bar()
  linear_extrude(height = thickness) tie_bar_outline();

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

module disc(r) {
  n = facets(r);
  circle(r = straddled(r, n), $fn = n);
}

module part() tie_bar();

if (as_scanned) scan_from_part() part();
else part();
