{{#facets}}
// Number of facets around a circle of radius r; a multiple of 4, so that corners lie on the axes.
// Half of chord_error is spent around, half along a profile.
function facets(r) = 4 * ceil(22.5 / atan(sqrt(chord_error / 2 / max(r, chord_error))));

// Radius of a polygon with n corners that is as far outside a circle of radius r as inside.
function straddled(r, n) = 2 * r / (1 + cos(180 / n));

{{/facets}}
{{#arc}}
// Points on the arc about center from one angle to another, both ends included.
function arc(center, r, from, to) =
  let (step = 2 * acos(1 - chord_error / 2 / max(r, chord_error)),
       n = ceil(abs(to - from) / step))
  [for (i = [0 : n]) let (a = i == n ? to : from + (to - from) * i / n) center + r * [cos(a), sin(a)]];

{{/arc}}
{{#on_axis}}
// A profile whose rounding errors next to the axis are taken out.
function on_axis(points) = [for (p = points) [abs(p.x) < 1e-6 ? 0 : p.x, p.y]];

{{/on_axis}}
{{#disc}}
module disc(r) {
  n = facets(r);
  circle(r = straddled(r, n), $fn = n);
}

{{/disc}}
{{#bore}}
// A round cutter about z.
module round_cutter(d, from, to) {
  n = facets(d / 2);
  translate([0, 0, from]) cylinder(r = straddled(d / 2, n), h = to - from, $fn = n);
}

{{/bore}}
{{#ball}}
// sphere() has no corners at its poles, the turned half disc does.
module ball(r) {
  n = facets(r);
  rotate_extrude($fn = n) scale([straddled(1, n), 1]) polygon(arc([0, 0], r, -90, 90));
}

{{/ball}}
