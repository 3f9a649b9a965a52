#include "testing/recovery/parts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/ensure.h"
#include "core/number.h"
#include "geometry/mesh/convex.h"

namespace partscribe::testing::recovery {
namespace {

/// Collects the named lengths of a part.
struct Sizes {
  std::vector<Parameter> parameters;
  Expr operator()(const std::string& name, double value, Quantity quantity = Quantity::length) {
    Parameter p;
    p.name = name, p.quantity = quantity, p.value = p.fitted = value;
    parameters.push_back(p);
    return Expr::of(name);
  }
};

Part part_of(Shape shape, const Sizes& sizes, const Vec3& low, const Vec3& high) {
  Part part;
  part.model.as_scanned = false;
  part.model.parameters = sizes.parameters;
  part.model.objects.push_back({"truth", std::move(shape), {}, {}, {}});
  part.bounds.add(low), part.bounds.add(high);
  return part;
}

Part sphere(Random& random) {
  Sizes s;
  const double r = random.uniform(12, 45);
  return part_of(Sphere{s("radius", r)}, s, Vec3::Constant(-r), Vec3::Constant(r));
}

Part ellipsoid(Random& random) {
  Sizes s;
  const double a = random.uniform(20, 50), b = a * random.uniform(0.6, 0.85), c = b * random.uniform(0.6, 0.85);
  const Vec3 r(a, b, c);
  return part_of(Ellipsoid{s("radius_x", a), s("radius_y", b), s("radius_z", c)}, s, -r, r);
}

Part superellipsoid(Random& random) {
  Sizes s;
  const double size = random.uniform(20, 45);
  Vec3 a;
  for (int k = 0; k < 3; ++k) a[k] = size * random.uniform(0.5, 1);
  const double e1 = random.uniform(0.4, 0.65), e2 = random.uniform(0.4, 0.65);
  return part_of(Superellipsoid{s("a1", a[0]), s("a2", a[1]), s("a3", a[2]), s("e1", e1, Quantity::ratio),
                                s("e2", e2, Quantity::ratio), 0, 0},
                 s, -a, a);
}

Part box(Random& random) {
  Sizes s;
  const double x = random.uniform(30, 100), y = x * random.uniform(0.5, 0.9), z = y * random.uniform(0.4, 0.9);
  return part_of(Box{s("length", x), s("width", y), s("height", z)}, s, Vec3::Zero(), Vec3(x, y, z));
}

Part wedge(Random& random) {
  Sizes s;
  const double x = random.uniform(30, 80), y = x * random.uniform(0.5, 0.9), z = x * random.uniform(0.4, 0.9);
  const bool prism = random.uniform() < 0.4;
  const double top = x * random.uniform(0.3, 0.6);
  const Expr sx = s("foot_length", x), sy = s("height", y), sz = s("width", z);
  return part_of(Wedge{sx, sy, sz, prism ? Expr(0) : s("top_length", top)}, s, Vec3::Zero(), Vec3(x, y, z));
}

Part cylinder(Random& random) {
  Sizes s;
  const double r = random.uniform(8, 30), h = r * random.uniform(1, 6);
  return part_of(Cylinder{s("radius", r), s("height", h)}, s, Vec3(-r, -r, 0), Vec3(r, r, h));
}

Part cone(Random& random) {
  Sizes s;
  const double r = random.uniform(10, 35), h = r * random.uniform(1, 3.5);
  const bool pointed = random.uniform() < 0.4;
  const double top = r * random.uniform(0.25, 0.65);
  const Expr bottom = s("bottom_radius", r);
  const Expr upper = pointed ? Expr(0) : s("top_radius", top);
  return part_of(Cone{bottom, upper, s("height", h)}, s, Vec3(-r, -r, 0), Vec3(r, r, h));
}

Part torus(Random& random) {
  Sizes s;
  const double ring = random.uniform(12, 40), tube = ring * random.uniform(0.25, 0.6);
  const double out = ring + tube;
  return part_of(Torus{s("major_radius", ring), s("minor_radius", tube)}, s, Vec3(-out, -out, -tube),
                 Vec3(out, out, tube));
}

/// A ring with rounded corners, whose tube is between round and nearly square.
Part supertoroid(Random& random) {
  Sizes s;
  const double ring = random.uniform(15, 40), tube = ring * random.uniform(0.25, 0.5),
               half = tube * random.uniform(0.75, 1.4);
  const double e1 = random.uniform(0.4, 1), e2 = random.uniform(0.4, 0.7);
  const double out = ring + tube;
  return part_of(Supertoroid{s("major_radius", ring), s("minor_radius", tube), s("half_height", half),
                             s("e1", e1, Quantity::ratio), s("e2", e2, Quantity::ratio)},
                 s, Vec3(-out, -out, -half), Vec3(out, out, half));
}

/// Round in half of the cases, else with clearly unequal legs.
Part fillet(Random& random) {
  Sizes s;
  const double width = random.uniform(15, 40), height = width * random.uniform(0.5, 0.85),
               length = width * random.uniform(0.6, 3);
  if (random.uniform() < 0.5) {
    const Expr r = s("radius", width);
    return part_of(Fillet{r, r, s("length", length)}, s, Vec3::Zero(), Vec3(width, width, length));
  }
  return part_of(Fillet{s("width", width), s("height", height), s("length", length)}, s, Vec3::Zero(),
                 Vec3(width, height, length));
}

Part half_spaces(Random& random) {
  for (int attempt = 0; attempt < 100000; ++attempt) {
    const std::size_t count = 5 + random.below(4);
    const double r = random.uniform(15, 40);
    std::vector<Plane3> planes;
    for (int tries = 0; tries < 200 && planes.size() < count; ++tries) {
      Vec3 n{random.normal(), random.normal(), random.normal()};
      n.normalize();
      if (std::all_of(planes.begin(), planes.end(), [&](const Plane3& p) { return p.normal.dot(n) < 0.7; }))
        planes.push_back({n, r * random.uniform(0.75, 1)});
    }
    const auto body = planes.size() == count ? convex_polyhedron(planes) : std::nullopt;
    if (!body) continue;
    double total = 0, least = 1e300;
    for (std::size_t f = 0; f < count; ++f) {
      const double a = face_area(*body, f);
      total += a, least = std::min(least, a);
    }
    Box3 bounds;
    for (const Vec3& v : body->vertices) bounds.add(v);
    if (least < 0.06 * total || bounds.size().maxCoeff() > 3.5 * r) continue;
    Sizes s;
    HalfSpaces shape;
    for (std::size_t f = 0; f < count; ++f) {
      const Vec3& n = planes[f].normal;
      shape.planes.push_back({n.x(), n.y(), n.z(), s("offset_" + std::to_string(f + 1), planes[f].offset), ""});
    }
    return part_of(shape, s, bounds.low, bounds.high);
  }
  ensure(false, "a convex body is found");
  return {};
}

/// A stepped pin; its head may be rounded.
Part revolve(Random& random) {
  Sizes s;
  const std::size_t steps = 2 + random.below(2);
  const double r = random.uniform(12, 30);
  std::vector<double> radius = {r}, height;
  for (std::size_t i = 1; i < steps; ++i) {
    // Up or down, but clearly.
    const double before = radius.back();
    double next = before * (random.uniform() < 0.6 ? random.uniform(0.4, 0.7) : random.uniform(1.3, 1.6));
    if (next > 1.2 * r || next < 0.3 * r) next = 0.55 * r;
    radius.push_back(next);
  }
  double z = 0;
  for (std::size_t i = 0; i < steps; ++i) height.push_back(z += r * random.uniform(0.6, 1.6));
  const bool round = random.uniform() < 0.4;
  const double blend = random.uniform(0.25, 0.5) * std::min(radius[0], height[0]);
  Loop loop;
  loop.name = "profile";
  loop.elements.push_back(SketchPoint{0, 0, ""});
  std::vector<Expr> re, he;
  for (std::size_t i = 0; i < steps; ++i) {
    re.push_back(s("radius_" + std::to_string(i + 1), radius[i]));
    he.push_back(s("height_" + std::to_string(i + 1), height[i]));
  }
  for (std::size_t i = 0; i < steps; ++i) {
    if (i == 0 && round) {
      const Expr b = s("round_radius", blend);
      loop.elements.push_back(SketchArc{re[0] - b, b, b, -pi / 2, 0, "", ""});
    } else {
      loop.elements.push_back(SketchPoint{re[i], i == 0 ? Expr(0) : he[i - 1], ""});
    }
    loop.elements.push_back(SketchPoint{re[i], he[i], ""});
  }
  loop.elements.push_back(SketchPoint{0, he.back(), ""});
  const double most = *std::max_element(radius.begin(), radius.end());
  return part_of(Revolve{{{loop}}}, s, Vec3(-most, -most, 0), Vec3(most, most, z));
}

Loop round_hole(const Expr& x, const Expr& y, const Expr& r) {
  Loop loop;
  loop.name = "hole";
  loop.elements = {SketchArc{x, y, r, 2 * pi, 0, "", ""}};
  return loop;
}

/// A tie bar, a plate with rounded corners and holes, or an angle.
Part extrude(Random& random) {
  Sizes s;
  const double kind = random.uniform();
  Loop outline;
  outline.name = "outline";
  if (kind < 0.4) {
    const double end = random.uniform(10, 20), spacing = end * random.uniform(2, 4), h = end * random.uniform(0.5, 1.2);
    const Expr e = s("end_radius", end), l = s("spacing", spacing);
    outline.elements = {SketchArc{l, 0, e, -pi / 2, pi / 2, "", ""}, SketchArc{0, 0, e, pi / 2, 3 * pi / 2, "", ""}};
    const Expr hole = s("hole_radius", end * random.uniform(0.35, 0.6));
    return part_of(Extrude{{{outline, round_hole(0, 0, hole), round_hole(l, 0, hole)}}, s("thickness", h)}, s,
                   Vec3(-end, -end, 0), Vec3(spacing + end, end, h));
  }
  const double x = random.uniform(40, 90), y = x * random.uniform(0.5, 0.8), h = x * random.uniform(0.15, 0.4);
  const Expr ex = s("length", x), ey = s("width", y);
  if (kind < 0.7) {
    const Expr c = s("corner_radius", y * random.uniform(0.12, 0.3));
    outline.elements = {SketchArc{ex - c, c, c, -pi / 2, 0, "", ""}, SketchArc{ex - c, ey - c, c, 0, pi / 2, "", ""},
                        SketchArc{c, ey - c, c, pi / 2, pi, "", ""}, SketchArc{c, c, c, pi, 1.5 * pi, "", ""}};
    const Expr hole = s("hole_radius", y * random.uniform(0.12, 0.22));
    const Expr hx = s("hole_x", x * random.uniform(0.3, 0.7));
    return part_of(Extrude{{{outline, round_hole(hx, ey / Expr(2), hole)}}, s("thickness", h)}, s, Vec3::Zero(),
                   Vec3(x, y, h));
  }
  const Expr a = s("foot", y * random.uniform(0.3, 0.5)), b = s("web", x * random.uniform(0.25, 0.5));
  for (const auto& [px, py] : std::vector<std::pair<Expr, Expr>>{{0, 0}, {ex, 0}, {ex, a}, {b, a}, {b, ey}, {0, ey}})
    outline.elements.push_back(SketchPoint{px, py, ""});
  const double high = x * random.uniform(0.3, 0.8);
  return part_of(Extrude{{{outline}}, s("thickness", high)}, s, Vec3::Zero(), Vec3(x, y, high));
}

Part slim_cone(Random& random) {
  Sizes s;
  const double r = random.uniform(10, 25), h = r * random.uniform(1.5, 4), top = r - h * std::tan(pi / 180);
  return part_of(Cone{s("bottom_radius", r), s("top_radius", top), s("height", h)}, s, Vec3(-r, -r, 0), Vec3(r, r, h));
}

Part ring_of(double major, double minor) {
  Sizes s;
  const double out = major + minor;
  return part_of(Torus{s("major_radius", major), s("minor_radius", minor)}, s, Vec3(-out, -out, -minor),
                 Vec3(out, out, minor));
}

Part round_ellipsoid(Random& random) {
  Sizes s;
  const double a = random.uniform(20, 45);
  const double b = a * random.uniform(0.97, 1);
  const Vec3 r(a, b, b * random.uniform(0.98, 1));
  return part_of(Ellipsoid{s("radius_x", r[0]), s("radius_y", r[1]), s("radius_z", r[2])}, s, -r, r);
}

}  // namespace

Part random_part(const std::string& kind, Random& random) {
  if (kind == "sphere") return sphere(random);
  if (kind == "ellipsoid") return ellipsoid(random);
  if (kind == "superellipsoid") return superellipsoid(random);
  if (kind == "box") return box(random);
  if (kind == "wedge") return wedge(random);
  if (kind == "cylinder") return cylinder(random);
  if (kind == "cone") return cone(random);
  if (kind == "torus") return torus(random);
  if (kind == "supertoroid") return supertoroid(random);
  if (kind == "fillet") return fillet(random);
  if (kind == "half_spaces") return half_spaces(random);
  if (kind == "revolve") return revolve(random);
  ensure(kind == "extrude", "the kind must be known");
  return extrude(random);
}

Part degenerate_part(const std::string& kind, Random& random) {
  if (kind == "cone_1deg") return slim_cone(random);
  if (kind == "ellipsoid_round") return round_ellipsoid(random);
  const double ring = random.uniform(12, 40);
  if (kind == "torus_fat") return ring_of(ring, ring * random.uniform(0.9, 0.98));
  Part part = kind == "torus_patch" ? ring_of(ring, ring * random.uniform(0.4, 0.8)) : cylinder(random);
  ensure(kind == "torus_patch" || kind == "cylinder_30deg", "the kind must be known");
  part.arc = pi / 6;
  return part;
}

}  // namespace partscribe::testing::recovery
