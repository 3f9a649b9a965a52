// Tie bar
//
// Units: millimetres and degrees. Tolerance: 0.15 mm.
// Fit: rms 0.02 mm from 30,858 points, local mean within 0.019 mm, 100 % of its surface scanned.
// Source: scan.json, view_00.png, view_01.png, view_02.png and 5 more.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Plate] */
// width, twice the radius of the round ends [mm]
width = 30;                            // fitted 30 +/- 0.002 from 10,049 points; nominal 30 (multiples of 10 mm, z = 0.2)
// distance between the centres of the ends [mm]
center_distance = 80;                  // fitted 80 +/- 0.001 from 2,036 points; nominal 80 (multiples of 10 mm, z = 0)
// diameter of hole 1 [mm]
hole_d = 16;                           // fitted 16 +/- 0.003 from 791 points; nominal 16 (preferred numbers R20, z = -0.1)
// diameter of hole 2 [mm]
hole_2_d = as_designed ? 10 : 10.001;  // fitted 10.001 +/- 0.003 from 313 points; nominal 10 (multiples of 10 mm, z = -0.4)
// thickness [mm]
thickness = 12;                        // fitted 12 +/- 0.001 from 9,813 points; nominal 12 (multiples of 1 mm, z = 0.3)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.015;

assert(width > 0, "width must be positive");
assert(hole_d > 0, "hole_d must be positive");
assert(hole_2_d > 0, "hole_2_d must be positive");
assert(thickness > 0, "thickness must be positive");

module plate_outline() difference() {
  polygon([
    each arc([center_distance, 0], width / 2, -90, 90),  // end, then back
    each arc([0, 0], width / 2, 90, 270)                 // end, then front
  ]);  // outline
  disc(hole_d / 2);  // hole 1
  translate([center_distance, 0]) disc(hole_2_d / 2);  // hole 2
}

module plate()
  linear_extrude(height = thickness) plate_outline();

// From the part's own frame to the scan's.
module scan_from_part() translate([-20, 35, 8]) rotate([-22.9169, 14.3243, 63.0247]) children();

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

module part() plate();

if (as_scanned) scan_from_part() part();
else part();
