// Pin: a headed pin, turned
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: pin.ply.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Pin] */
// radius of the shank [mm]
shank_radius = as_designed ? 9 : 8.9987;   // fitted 8.9987 +/- 0.0004 from 4,120 points; nominal 9 (0.5 mm grid, z = 3.3)
// length of the shank below the head [mm]
shank_length = as_designed ? 60 : 60.004;  // fitted 60.004 +/- 0.006 from 4,120 points; nominal 60 (0.5 mm grid, z = -0.7)
// radius of the head [mm]
head_radius = as_designed ? 15 : 14.993;   // fitted 14.993 +/- 0.001 from 4,120 points; nominal 15 (0.5 mm grid, z = 5.7)
// height of the head [mm]
head_height = as_designed ? 10 : 10.002;   // fitted 10.002 +/- 0.004 from 4,120 points; nominal 10 (0.5 mm grid, z = -0.5)
// radius of the rounded upper edge of the head [mm]
fillet_radius = as_designed ? 2 : 1.994;   // fitted 1.994 +/- 0.009 from 4,120 points; nominal 2 (0.5 mm grid, z = 0.7)
// size of the bevel at the foot of the shank [mm]
chamfer = as_designed ? 1.5 : 1.48;        // fitted 1.48 +/- 0.02 from 4,120 points; nominal 1.5 (0.5 mm grid, z = 1.3)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(fillet_radius > 0, "fillet_radius must be positive");

module pin_profile()
  polygon([
    [0, 0],                          // foot
    [shank_radius - chamfer, 0],     // bevel
    [shank_radius, chamfer],         // shank
    [shank_radius, shank_length],    // shoulder
    [head_radius, shank_length],     // head
    // fillet, then top
    each arc([head_radius - fillet_radius, shank_length + head_height - fillet_radius], fillet_radius, 0, 90),
    [0, shank_length + head_height]  // axis
  ]);

module pin() {
  n = facets(head_radius);
  rotate_extrude($fn = n) scale([straddled(1, n), 1]) pin_profile();
}

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

module part() pin();

if (as_scanned) scan_from_part() part();
else part();
