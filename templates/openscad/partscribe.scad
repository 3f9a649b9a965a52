// Shapes that OpenSCAD does not have: superellipsoids, supertoroids, NURBS curves and surfaces, bodies with leaning
// walls, half-spaces and thickened sheets.
//
// Belongs beside the script that uses it. Millimetres and degrees; OpenSCAD 2021.01 or later.

// Distance of p from the straight line through a and b, in two or three dimensions.
function _off_line(p, a, b) =
  let (d = b - a, l = d * d, q = p - a)
  l == 0 ? norm(q) : norm(q - d * min(1, max(0, (q * d) / l)));

// Parameters between a and b at which the curve f has to be cut so that no chord is farther from it than error.
function _cuts(f, a, b, error, depth = 0) =
  let (p = f(a), q = f(b), m = (a + b) / 2,
       far = max(_off_line(f(m), p, q), _off_line(f((a + m) / 2), p, q), _off_line(f((m + b) / 2), p, q)))
  depth > 14 || (depth > 0 && far <= error) ? []
  : concat(_cuts(f, a, m, error, depth + 1), [m], _cuts(f, m, b, error, depth + 1));

// ---- superellipsoid -------------------------------------------------------------------------------------------

// The point of the unit superellipse |x|^(2/e) + |y|^(2/e) = 1 in a direction.
function _superellipse(angle, e) =
  let (c = cos(angle), s = sin(angle), p = 2 / e)
  [c, s] / (abs(c) ^ p + abs(s) ^ p) ^ (1 / p);

// How far a corner lies off the plane of the three others, at most, in a ring of four-cornered facets.
function _twist(rows) =
  max([for (i = [0 : len(rows) - 2], j = [0 : len(rows[i]) - 1])
    let (k = (j + 1) % len(rows[i]), p = rows[i][j], a = rows[i][k] - p, b = rows[i + 1][j] - p,
         c = rows[i + 1][k] - p, w = cross(a, b))
    norm(w) < 1e-12 ? 0 : abs(w * c) / norm(w)]);

// Where a point goes when the z axis is bent towards +x into an arc, by an angle over a length of z.
function _bent(p, bend, over) =
  bend == 0 ? p : let (r = over / bend * 180 / PI, turn = bend * p.z / over)
    [r - (r - p.x) * cos(turn), p.y, (r - p.x) * sin(turn)];

// The surface ((x/a1)^(2/e2) + (y/a2)^(2/e2))^(e2/e1) + (z/a3)^(2/e1) = 1 with half sizes [a1, a2, a3], then x grown
// by 1 + taper.x z / a3 and y by 1 + taper.y z / a3, then the z axis bent towards +x by an angle over a3. Corners lie
// on the surface, facets within chord_error of it.
module superellipsoid(size, e1 = 1, e2 = 1, taper = [0, 0], bend = 0, chord_error = 0.01) {
  assert(min(size) > 0, "the half sizes of a superellipsoid must be positive");
  assert(e1 >= 0.1 && e1 <= 2 && e2 >= 0.1 && e2 <= 2, "the exponents of a superellipsoid must lie in 0.1 .. 2");
  assert(max(abs(taper.x), abs(taper.y)) < 1, "the taper of a superellipsoid must lie between -1 and 1");
  grown = [for (i = [0, 1]) size[i] * (1 + abs(taper[i]))];
  assert(abs(bend) < 180 && grown.x * abs(bend) * PI / 180 < size.z,
    "a superellipsoid must be bent by less than half a turn, with a radius above its half width");
  straight = function (t, side) let (p = _superellipse(t, e1))
    [p.x * side * size.x * (1 + taper.x * p.y), p.x * size.y * (1 + taper.y * p.y), p.y * size.z];
  // Inside and outside of the bend.
  meridian = function (t) bend == 0 ? straight(t, 1)
    : concat(_bent(straight(t, 1), bend, size.z), _bent(straight(t, -1), bend, size.z));
  ring = function (t) let (p = _superellipse(t, e2)) [p.x * grown.x, p.y * grown.y];
  latitudes = concat(_cuts(meridian, -90, 0, chord_error / 2), [0], _cuts(meridian, 0, 90, chord_error / 2));
  quarter = concat([0], _cuts(ring, 0, 90, chord_error / 2));
  coarse = [for (k = [0 : 3]) each [for (t = quarter) t + 90 * k]];
  m = len(latitudes);
  rows = function (longitudes) let (unit = [for (t = longitudes) _superellipse(t, e2)])
    [for (t = latitudes) let (p = _superellipse(t, e1), gx = 1 + taper.x * p.y, gy = 1 + taper.y * p.y)
      [for (u = unit) _bent([p.x * u.x * size.x * gx, p.x * u.y * size.y * gy, p.y * size.z], bend, size.z)]];
  // Where taper and bend twist the facets, more of them share the twist.
  shares = max(1, ceil(_twist(rows(coarse)) / chord_error));
  longitudes = [for (j = [0 : len(coarse) - 1]) let (to = j + 1 < len(coarse) ? coarse[j + 1] : 360)
    each [for (k = [0 : shares - 1]) coarse[j] + (to - coarse[j]) * k / shares]];
  n = len(longitudes);
  tips = [for (z = [-size.z, size.z]) _bent([0, 0, z], bend, size.z)];
  points = concat([tips[0]], [for (row = rows(longitudes)) each row], [tips[1]]);
  top = len(points) - 1;
  faces = concat(
    [for (j = [0 : n - 1]) [0, 1 + j, 1 + (j + 1) % n]],
    [for (i = [0 : m - 2], j = [0 : n - 1]) let (a = 1 + i * n, k = (j + 1) % n)
      each [[a + j, a + n + j, a + n + k], [a + j, a + n + k, a + k]]],
    [for (j = [0 : n - 1]) [top, top - n + (j + 1) % n, top - n + j]]);
  polyhedron(points = points, faces = faces);
}

// ---- supertoroid ----------------------------------------------------------------------------------------------

// The surface |(r - major) / minor|^(2/e1) + |z / half_height|^(2/e1) = 1 with r = (|x|^(2/e2) + |y|^(2/e2))^(e2/2).
// Corners lie on the surface, facets within chord_error of it; every facet is plane.
module supertoroid(major_radius, minor_radius, half_height, e1 = 1, e2 = 1, chord_error = 0.01) {
  assert(minor_radius > 0 && minor_radius < major_radius && half_height > 0,
    "a supertoroid needs a tube that is thinner than its ring");
  assert(e1 >= 0.1 && e1 <= 2 && e2 >= 0.1 && e2 <= 2, "the exponents of a supertoroid must lie in 0.1 .. 2");
  tube = function (t) let (p = _superellipse(t, e1)) [p.x * minor_radius, p.y * half_height];
  ring = function (t) (major_radius + minor_radius) * _superellipse(t, e2);
  around = function (curve) let (quarter = concat([0], _cuts(curve, 0, 90, chord_error / 2)))
    [for (k = [0 : 3]) each [for (t = quarter) t + 90 * k]];
  unit = [for (t = around(ring)) _superellipse(t, e2)];
  n = len(unit);
  sections = [for (t = around(tube)) tube(t)];
  m = len(sections);
  points = [for (s = sections, u = unit) [(major_radius + s.x) * u.x, (major_radius + s.x) * u.y, s.y]];
  faces = [for (i = [0 : m - 1], j = [0 : n - 1])
    let (a = i * n, b = ((i + 1) % m) * n, k = (j + 1) % n)
    each [[a + j, b + k, a + k], [a + j, b + j, b + k]]];
  polyhedron(points = points, faces = faces, convexity = 4);
}

// ---- NURBS curve ----------------------------------------------------------------------------------------------

// The knot span that holds u: the last i with knots[i] <= u < knots[i + 1].
function _span(knots, degree, count, u) =
  let (inside = [for (i = [degree : count - 1]) if (knots[i] <= u && knots[i] < knots[i + 1]) i])
  inside[len(inside) - 1];

// De Boor's scheme on homogeneous points.
function _de_boor(points, knots, degree, span, u, round = 1) =
  round > degree ? points[degree]
  : _de_boor([for (j = [0 : degree])
      j < round ? points[j]
      : let (k = span - degree + j, t = (u - knots[k]) / (knots[k + degree - round + 1] - knots[k]))
        (1 - t) * points[j - 1] + t * points[j]], knots, degree, span, u, round + 1);

function nurbs_point(degree, knots, homogeneous, u) =
  let (span = _span(knots, degree, len(homogeneous), u),
       h = _de_boor([for (j = [0 : degree]) homogeneous[span - degree + j]], knots, degree, span, u))
  [h.x, h.y] / h.z;

// Points along a clamped plane NURBS curve, both ends included, so that no chord is farther from it than error.
function nurbs_curve(degree, knots, control, weights = undef, error = 0.01) =
  let (count = len(control),
       w = weights == undef ? [for (p = control) 1] : weights,
       homogeneous = [for (i = [0 : count - 1]) [control[i].x * w[i], control[i].y * w[i], w[i]]],
       curve = function (u) nurbs_point(degree, knots, homogeneous, u),
       spans = [for (i = [degree : count - 1]) if (knots[i] < knots[i + 1]) i])
  assert(len(knots) == count + degree + 1, "a NURBS curve has as many knots as control points + degree + 1")
  concat([control[0]],
    [for (i = spans) each concat([for (u = _cuts(curve, knots[i], knots[i + 1], error)) curve(u)],
      [i == count - 1 || knots[i + 1] >= knots[count] ? control[count - 1] : curve(knots[i + 1])])]);

// ---- drafted extrusion ----------------------------------------------------------------------------------------

// Where an element of a loop begins and ends: a corner [x, y], or an arc [center, radius, from, to] (degrees).
function _start(e) = len(e) == 4 ? e[0] + e[1] * [cos(e[2]), sin(e[2])] : e;
function _end(e) = len(e) == 4 ? e[0] + e[1] * [cos(e[3]), sin(e[3])] : e;

// The radius of an arc that has moved to its left by d.
function _moved_radius(e, d) = e[1] + (e[3] > e[2] ? -d : d);

// The unit normal to the left of the way from a to b.
function _left(a, b) = [a.y - b.y, b.x - a.x] / norm(b - a);

// Into how many chords each arc of a loop is cut that moves by the ways in d.
function _chords(loop, d, error) =
  [for (e = loop) len(e) < 4 ? 0
    : let (r = max(error, max([for (x = d) _moved_radius(e, x)])))
      len(loop) == 1 ? 4 * ceil(22.5 / atan(sqrt(error / r))) : ceil(abs(e[3] - e[2]) / (2 * acos(1 - error / r)))];

// Points around a loop when all its pieces have moved to their left by d: corners are mitred, a circle straddled.
function _moved(loop, d, chords) =
  let (k = len(loop))
  [for (i = [0 : k - 1])
    let (e = loop[i], n = chords[i], before = _end(loop[(i + k - 1) % k]), after = _start(loop[(i + 1) % k]))
    each len(e) < 4 ? let (l = _left(before, e), m = _left(e, after)) [e + d * (l + m) / (1 + l * m)]
      : let (r = _moved_radius(e, d) * (k == 1 ? 2 / (1 + cos(180 / n)) : 1))
        [for (j = [norm(before - _start(e)) < 1e-6 ? 1 : 0 : n]) let (a = e[2] + (e[3] - e[2]) * j / n)
          e[0] + r * [cos(a), sin(a)]]];

// The body between a loop moved by its ways at the bottom and at the top; a cut reaches straight out by `beyond`.
module _between(loop, z, d, error, beyond) {
  chords = _chords(loop, d, error);
  ends = [for (x = d) _moved(loop, x, chords)];
  n = len(ends[0]);
  assert(min([for (j = [0 : n - 1]) let (k = (j + 1) % n) (ends[0][k] - ends[0][j]) * (ends[1][k] - ends[1][j])]) > 0,
    "the draft is too large: an edge or an arc vanishes");
  turn = [for (p = ends[0]) 1] * [for (j = [0 : n - 1]) cross(ends[0][j], ends[0][(j + 1) % n])];
  heights = beyond > 0 ? [[z[0] - beyond, 0], [z[0], 0], [z[1], 1], [z[1] + beyond, 1]] : [[z[0], 0], [z[1], 1]];
  m = len(heights);
  points = [for (h = heights, j = [0 : n - 1]) let (p = ends[h[1]][turn > 0 ? j : n - 1 - j]) [p.x, p.y, h[0]]];
  polyhedron(points = points, convexity = 10, faces = concat(
    [[for (j = [0 : n - 1]) j]], [[for (j = [0 : n - 1]) m * n - 1 - j]],
    [for (i = [0 : m - 2], j = [0 : n - 1]) let (a = i * n, k = (j + 1) % n)
      each [[a + j, a + n + j, a + n + k], [a + j, a + n + k, a + k]]]));
}

// A sketch from z = -below to height whose walls lean inwards by `draft` as z rises: at height z all its pieces have
// moved into the material, which lies to the left of every loop, by z * tan(draft). Arcs join tangentially. The first
// loop is the outer one, counter-clockwise; the others are holes, clockwise.
module drafted(loops, height, below = 0, draft = 0, chord_error = 0.01) {
  assert(height > 0 && below >= 0 && abs(draft) < 90, "a drafted body needs a height, and a draft below 90 degrees");
  z = [-below, height];
  d = z * tan(draft);
  difference() {
    _between(loops[0], z, d, chord_error / 2, 0);
    for (i = [1 : 1 : len(loops) - 1]) _between(loops[i], z, d, chord_error / 2, 1);
  }
}

// ---- half-spaces ----------------------------------------------------------------------------------------------

// The convex body of all points p with normal * p <= distance, for every [normal, distance] in planes.
module half_spaces(planes) {
  n = len(planes);
  scale = max([for (p = planes) abs(p[1])]) + 1;
  corners = [for (i = [0 : n - 1], j = [i + 1 : 1 : n - 1], k = [j + 1 : 1 : n - 1])
    let (a = planes[i][0], b = planes[j][0], c = planes[k][0], det = a * cross(b, c))
    if (abs(det) > 1e-6)
      let (p = (planes[i][1] * cross(b, c) + planes[j][1] * cross(c, a) + planes[k][1] * cross(a, b)) / det)
      if (max([for (q = planes) q[0] * p - q[1]]) < 1e-7 * scale) p];
  assert(len(corners) >= 4, "the half-spaces have no common body");
  hull() polyhedron(points = corners, faces = [[for (i = [0 : len(corners) - 1]) i]]);
}

// ---- sheet ----------------------------------------------------------------------------------------------------

// A closed solid between an open sheet and its copy, moved back by thickness; rim lists the sheet's boundary edges.
module thick_sheet(points, normals, faces, rim, thickness) {
  assert(thickness > 0, "a sheet needs a thickness to become a solid");
  n = len(points);
  back = [for (i = [0 : n - 1]) points[i] - thickness * normals[i]];
  polyhedron(points = concat(points, back),
    faces = concat(faces, [for (f = faces) [f[2] + n, f[1] + n, f[0] + n]],
      [for (e = rim) each [[e[1], e[0], e[0] + n], [e[1], e[0] + n, e[1] + n]]]),
    convexity = 10);
}

// ---- NURBS surface --------------------------------------------------------------------------------------------

// The basis functions of a degree that live on the span, at u (Cox and de Boor).
function _basis(knots, degree, span, u) =
  degree == 0 ? [1]
  : let (lower = _basis(knots, degree - 1, span, u))
    [for (j = [0 : degree]) let (i = span - degree + j)
      (j > 0 ? lower[j - 1] * (u - knots[i]) / (knots[i + degree] - knots[i]) : 0) +
      (j < degree ? lower[j] * (knots[i + degree + 1] - u) / (knots[i + degree + 1] - knots[i + 1]) : 0)];

// A clamped surface from its control points, one row of them for each u. Weights likewise, all 1 where left out.
function spline_surface(degrees, knots_u, knots_v, control, weights = undef) =
  assert(len(knots_u) == len(control) + degrees[0] + 1 && len(knots_v) == len(control[0]) + degrees[1] + 1,
    "a surface needs as many knots as control points and its degree plus 1, along u and along v")
  [degrees, knots_u, knots_v,
   weights == undef ? control
   : [for (i = [0 : len(control) - 1]) [for (j = [0 : len(control[i]) - 1])
       concat(weights[i][j] * control[i][j], [weights[i][j]])]]];

// The point of a surface at [u, v].
function surface_point(surface, at) =
  let (p = surface[0][0], q = surface[0][1], rows = surface[3],
       s = _span(surface[1], p, len(rows), at[0]), t = _span(surface[2], q, len(rows[0]), at[1]),
       along = _basis(surface[2], q, t, at[1]),
       h = _basis(surface[1], p, s, at[0]) *
         [for (i = [s - p : s]) along * [for (j = [t - q : t]) rows[i][j]]])
  len(h) == 4 ? [h[0], h[1], h[2]] / h[3] : h;

// Outward unit normal, from points nearby.
function surface_normal(surface, at) =
  let (u = surface[1], v = surface[2], du = 1e-4 * (u[len(u) - 1] - u[0]), dv = 1e-4 * (v[len(v) - 1] - v[0]),
       a = max(at[0] - du, u[0]), b = min(at[0] + du, u[len(u) - 1]),
       c = max(at[1] - dv, v[0]), d = min(at[1] + dv, v[len(v) - 1]),
       n = cross(surface_point(surface, [b, at[1]]) - surface_point(surface, [a, at[1]]),
                 surface_point(surface, [at[0], d]) - surface_point(surface, [at[0], c])))
  n / norm(n);

function _corners(surfaces, corners) =
  [for (k = [0 : len(surfaces) - 1]) for (at = corners[k]) surface_point(surfaces[k], at)];

// The body that surfaces enclose; corners lists for each surface the places [u, v] of the corners of the triangles.
module surface_body(surfaces, corners, faces)
  polyhedron(points = _corners(surfaces, corners), faces = faces, convexity = 10);

// The same of an open sheet, thickened towards its back or, where that would fold, away from one direction.
module surface_sheet(surfaces, corners, faces, rim, thickness, towards = undef) {
  normals = [for (k = [0 : len(surfaces) - 1]) for (at = corners[k])
    towards == undef ? surface_normal(surfaces[k], at) : towards];
  thick_sheet(_corners(surfaces, corners), normals, faces, rim, thickness);
}

// What a sheet passes while it moves by a vector, which leaves it by the front everywhere or by the back everywhere.
module swept_surface(surfaces, corners, faces, rim, direction) {
  start = _corners(surfaces, corners);
  by_the_front = surface_normal(surfaces[0], corners[0][0]) * direction > 0;
  thick_sheet(by_the_front ? [for (p = start) p + direction] : start,
    [for (p = start) by_the_front ? direction : -direction], faces, rim, thickness = 1);
}
