// Sphere: a ball
//
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: sphere.ply.
// Written by partscribe 0.1.0.

/* [Switches] */
// true: the sizes the part was designed with, false: as it was built, with the fitted sizes
as_designed = true;
// true: where the scan has the part, false: in the part's own frame
as_scanned = true;

/* [Ball] */
// radius of the ball [mm]
radius = as_designed ? 25 : 24.996;  // fitted 24.996 +/- 0.002 from 4,120 points; nominal 25 (0.5 mm grid, z = 1.8)

/* [Quality] */
// largest distance between a curved surface and the facets that stand for it [mm]
chord_error = 0.01;

assert(radius > 0, "radius must be positive");

module ball_body()
  ball(radius);

// From the part's own frame to the scan's.
module scan_from_part() translate([10, 20, -5]) children();

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

// sphere() has no corners at its poles, the turned half disc does.
module ball(r) {
  n = facets(r);
  rotate_extrude($fn = n) scale([straddled(1, n), 1]) polygon(arc([0, 0], r, -90, 90));
}

module part() ball_body();

if (as_scanned) scan_from_part() part();
else part();
