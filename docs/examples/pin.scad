// Pin
//
// Units: millimetres and degrees. Tolerance: 0.08 mm.
// Fit: rms 0.0042 mm from 43,290 points, local mean within 0.0046 mm, 100 % of its surface scanned.
// Source: scan.json, view_00.png, view_01.png, view_02.png and 3 more.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Turned body] */
// radius of the fillet [mm]
fillet_radius = as_designed ? 1.5 : 1.5002;  // fitted 1.5002 +/- 0.0005 from 1,268 points; nominal 1.5 (multiples of 0.5 mm, z = -0.4)
// height of the head [mm]
head_height = as_designed ? 6 : 5.9997;      // fitted 5.9997 +/- 0.0002 from 3,299 points; nominal 6 (multiples of 1 mm, z = 1.1)
// diameter of the shank [mm]
shank_d = 12;                                // fitted 12 +/- 0.0004 from 27,153 points; nominal 12 (multiples of 1 mm, z = 0.1)
// diameter of the head [mm]
head_d = as_designed ? 20 : 19.9999;         // fitted 19.9999 +/- 0.0004 from 6,781 points; nominal 20 (multiples of 10 mm, z = 0.1)
// width and height of the 45 degree chamfer [mm]
chamfer = as_designed ? 1 : 1.0001;          // fitted 1.0001 +/- 0.0003 from 862 points; nominal 1 (multiples of 1 mm, z = -0.5)
// length over all [mm]
total_length = as_designed ? 46 : 45.9999;   // fitted 45.9999 +/- 0.0002 from 2,323 points; nominal 46 (multiples of 1 mm, z = 0.4)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.008;

assert(fillet_radius > 0, "fillet_radius must be positive");

module turned_body_profile()
  polygon([
    [0, 0],                                 // bottom face
    [head_d / 2, 0],                        // head
    [head_d / 2, head_height],              // shoulder
    // fillet, then shank
    each arc([shank_d / 2 + fillet_radius, head_height + fillet_radius], fillet_radius, -90, -180),
    [shank_d / 2, total_length - chamfer],  // chamfer
    [shank_d / 2 - chamfer, total_length],  // top face
    [0, total_length]                       // axis
  ]);

module turned_body() {
  n = facets(head_d / 2);
  rotate_extrude($fn = n) scale([straddled(1, n), 1]) turned_body_profile();
}

// From the part's own frame to the scan's.
module scan_from_part() translate([25.8715, -28.934, 66.2697]) rotate([-32.823, -159.7628, 0]) children();

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

module part() turned_body();

if (as_scanned) scan_from_part() part();
else part();
