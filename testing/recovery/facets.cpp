#include "testing/recovery/facets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/ensure.h"
#include "core/number.h"
#include "geometry/mesh/convex.h"
#include "model/distance/distance.h"
#include "model/lower/lower.h"
#include "model/sketch.h"

namespace partscribe::testing::recovery {
namespace {

using Polygon = std::vector<Vec2>;

double cross(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

double signed_area(const Polygon& p) {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < p.size(); ++i) sum += cross(p[0], p[i], p[i + 1]) / 2;
  return sum;
}

/// Corners of an outline, loop by loop, with `around` of them on a full circle.
std::vector<Polygon> corners_of(const EvaluatedSketch& sketch, int around) {
  std::vector<Polygon> loops(sketch.loops.size());
  for (const auto& c : outline_of(sketch).curves) {
    Polygon& loop = loops[static_cast<std::size_t>(c.loop)];
    int pieces = 1;
    if (const auto* arc = std::get_if<Arc2>(&c.curve))
      pieces = std::max(1, static_cast<int>(std::ceil(std::abs(arc->to - arc->from) / (2 * pi) * around - 1e-9)));
    if (std::holds_alternative<Nurbs2>(c.curve)) pieces = std::max(2, around / 4);
    for (int i = 0; i < pieces; ++i) {  // the last point is the next curve's first
      const double t = double(i) / pieces;
      if (const auto* arc = std::get_if<Arc2>(&c.curve))
        loop.push_back(arc->at(arc->from + t * (arc->to - arc->from)));
      else if (const auto* nurbs = std::get_if<Nurbs2>(&c.curve))
        loop.push_back(nurbs->at(nurbs->t.low() + t * (nurbs->t.high() - nurbs->t.low())));
      else
        loop.push_back(std::get<Line2>(c.curve).a);
    }
  }
  return loops;
}

bool properly_cross(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  return cross(a, b, c) * cross(a, b, d) < 0 && cross(c, d, a) * cross(c, d, b) < 0;
}

/// One polygon out of an outline (counter-clockwise) and its holes (clockwise), by cuts to each hole and back.
Polygon with_cuts(Polygon outline, std::vector<Polygon> holes) {
  for (std::size_t h = 0; h < holes.size(); ++h) {
    const auto crosses = [&](const Vec2& a, const Vec2& b) {
      const auto meets = [&](const Polygon& p) {
        for (std::size_t i = 0; i < p.size(); ++i)
          if (properly_cross(a, b, p[i], p[(i + 1) % p.size()])) return true;
        return false;
      };
      return meets(outline) || std::any_of(holes.begin() + static_cast<std::ptrdiff_t>(h), holes.end(), meets);
    };
    double shortest = 1e300;
    std::size_t from = 0, to = 0;
    for (std::size_t i = 0; i < outline.size(); ++i)
      for (std::size_t k = 0; k < holes[h].size(); ++k) {
        const double length = (outline[i] - holes[h][k]).norm();
        if (length < shortest && !crosses(outline[i], holes[h][k])) shortest = length, from = i, to = k;
      }
    Polygon cut = {outline[from]};
    for (std::size_t k = 0; k <= holes[h].size(); ++k) cut.push_back(holes[h][(to + k) % holes[h].size()]);
    outline.insert(outline.begin() + static_cast<std::ptrdiff_t>(from), cut.begin(), cut.end());
  }
  return outline;
}

/// Ear by ear; indices into the polygon.
std::vector<std::array<std::size_t, 3>> ears_of(const Polygon& polygon) {
  std::vector<std::size_t> left(polygon.size());
  std::iota(left.begin(), left.end(), std::size_t{0});
  std::vector<std::array<std::size_t, 3>> ears;
  while (left.size() > 3) {
    const std::size_t n = left.size();
    std::size_t ear = n;
    double best = 0;  // the largest ear: no slivers while there is a choice
    for (std::size_t i = 0; i < n; ++i) {
      const Vec2 &a = polygon[left[(i + n - 1) % n]], &b = polygon[left[i]], &c = polygon[left[(i + 1) % n]];
      const double size = cross(a, b, c);
      if (!(size > best)) continue;
      const bool empty = std::none_of(left.begin(), left.end(), [&](std::size_t k) {
        const Vec2& p = polygon[k];
        return p != a && p != b && p != c && cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0;
      });
      if (empty) best = size, ear = i;
    }
    ensure(ear < n, "a simple polygon has an ear");
    ears.push_back({left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  ears.push_back({left[0], left[1], left[2]});
  return ears;
}

void add_triangle(TriangleMesh& mesh, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
  mesh.triangles.push_back({first, first + 1, first + 2});
}

/// Walls over all loops, and both ends.
TriangleMesh prism(std::vector<Polygon> loops, double height) {
  std::size_t outer = 0;
  for (std::size_t i = 1; i < loops.size(); ++i)
    if (std::abs(signed_area(loops[i])) > std::abs(signed_area(loops[outer]))) outer = i;
  std::swap(loops[0], loops[outer]);
  for (std::size_t i = 0; i < loops.size(); ++i)
    if ((signed_area(loops[i]) > 0) != (i == 0)) std::reverse(loops[i].begin(), loops[i].end());
  TriangleMesh mesh;
  const auto at = [](const Vec2& p, double z) { return Vec3(p.x(), p.y(), z); };
  for (const auto& loop : loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
      add_triangle(mesh, at(a, 0), at(b, 0), at(b, height));
      add_triangle(mesh, at(a, 0), at(b, height), at(a, height));
    }
  const Polygon whole = with_cuts(loops[0], {loops.begin() + 1, loops.end()});
  for (const auto& [a, b, c] : ears_of(whole)) {
    add_triangle(mesh, at(whole[a], height), at(whole[b], height), at(whole[c], height));
    add_triangle(mesh, at(whole[a], 0), at(whole[c], 0), at(whole[b], 0));
  }
  return mesh;
}

/// The surface point(i, k) over a grid; closed along k, and along i too if asked for.
template <class Point>
TriangleMesh grid(int rows, int columns, bool closed, const Point& point) {
  TriangleMesh mesh;
  const auto at = [&](int i, int k) { return point(closed ? i % rows : i, k % columns); };
  for (int i = 0; i < (closed ? rows : rows - 1); ++i)
    for (int k = 0; k < columns; ++k) {
      add_triangle(mesh, at(i, k), at(i, k + 1), at(i + 1, k + 1));
      add_triangle(mesh, at(i, k), at(i + 1, k + 1), at(i + 1, k));
    }
  return mesh;
}

TriangleMesh turned(const Polygon& profile, bool closed, int around) {
  return grid(static_cast<int>(profile.size()), around, closed, [&](int i, int k) {
    const double a = 2 * pi * k / around;
    const Vec2& p = profile[static_cast<std::size_t>(i)];
    return p.x() == 0 ? Vec3(0, 0, p.y()) : Vec3(p.x() * std::cos(a), p.x() * std::sin(a), p.y());
  });
}

/// The point of |x|^(2/e) + |y|^(2/e) = 1 in the direction of an angle.
Vec2 superellipse(double angle, double e) {
  const Vec2 u(std::cos(angle), std::sin(angle));
  return u / std::pow(std::pow(std::abs(u.x()), 2 / e) + std::pow(std::abs(u.y()), 2 / e), e / 2);
}

TriangleMesh lobe(const Vec3& a, double e1, double e2, int around) {
  const int rows = around / 2;
  return grid(rows + 1, around, false, [&](int i, int k) {
    if (i == 0 || i == rows) return Vec3(0, 0, i == 0 ? -a.z() : a.z());
    const Vec2 side = superellipse(pi * (double(i) / rows - 0.5), e1), top = superellipse(2 * pi * k / around, e2);
    return Vec3(a.x() * side.x() * top.x(), a.y() * side.x() * top.y(), a.z() * side.y());
  });
}

TriangleMesh ring(const SupertoroidOf<double>& s, int around) {
  return grid(std::max(8, around / 2), around, true, [&](int i, int k) {
    const Vec2 tube = superellipse(2 * pi * i / std::max(8, around / 2), s.e1),
               top = superellipse(2 * pi * k / around, s.e2);
    const double r = s.major_radius + s.minor_radius * tube.x();
    return Vec3(r * top.x(), r * top.y(), s.half_height * tube.y());
  });
}

TriangleMesh half_space_mesh(const HalfSpacesOf<double>& s) {
  std::vector<Plane3> planes;
  for (const auto& p : s.planes) planes.push_back({{p.normal_x, p.normal_y, p.normal_z}, p.offset});
  const auto body = convex_polyhedron(planes);
  ensure(body.has_value(), "a part is bounded");
  return triangulated(*body);
}

TriangleMesh mesh_of(const EvaluatedShape& shape, int around) {
  if (const auto* s = std::get_if<SphereOf<double>>(&shape)) return lobe(Vec3::Constant(s->radius), 1, 1, around);
  if (const auto* s = std::get_if<EllipsoidOf<double>>(&shape))
    return lobe({s->radius_x, s->radius_y, s->radius_z}, 1, 1, around);
  if (const auto* s = std::get_if<SuperellipsoidOf<double>>(&shape))
    return lobe({s->a1, s->a2, s->a3}, s->e1, s->e2, around);
  if (const auto* s = std::get_if<TorusOf<double>>(&shape))
    return ring({s->major_radius, s->minor_radius, s->minor_radius, 1, 1}, around);
  if (const auto* s = std::get_if<SupertoroidOf<double>>(&shape)) return ring(*s, around);
  if (const auto* s = std::get_if<BoxOf<double>>(&shape))
    return prism({{{0, 0}, {s->size_x, 0}, {s->size_x, s->size_y}, {0, s->size_y}}}, s->size_z);
  if (const auto* s = std::get_if<WedgeOf<double>>(&shape)) {
    Polygon side = {{0, 0}, {s->size_x, 0}, {s->top_x, s->size_y}};
    if (s->top_x > 0) side.push_back({0, s->size_y});
    return prism({side}, s->size_z);
  }
  if (const auto* s = std::get_if<CylinderOf<double>>(&shape))
    return turned({{0, 0}, {s->radius, 0}, {s->radius, s->height}, {0, s->height}}, false, around);
  if (const auto* s = std::get_if<ConeOf<double>>(&shape))
    return turned({{0, 0}, {s->bottom_radius, 0}, {s->top_radius, s->height}, {0, s->height}}, false, around);
  if (const auto* s = std::get_if<RevolveOf<double>>(&shape))
    return turned(corners_of(s->sketch, around)[0], true, around);
  if (const auto* s = std::get_if<ExtrudeOf<double>>(&shape)) return prism(corners_of(s->sketch, around), s->height);
  const auto* s = std::get_if<HalfSpacesOf<double>>(&shape);
  ensure(s != nullptr, "the kind has a mesh");
  return half_space_mesh(*s);
}

}  // namespace

TriangleMesh coarse_mesh(const Model& truth, int around) {
  const Model simple = lowered(truth, values_of(truth));
  TriangleMesh mesh = mesh_of(evaluate(simple.objects.back().shape, {}), around);
  mesh = welded(mesh, 1e-9);
  if (volume(mesh) < 0)
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

double sagitta_of(const TriangleMesh& mesh, const Model& truth) {
  const ModelDistance distance(truth);
  double most = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const Vec3& share : {Vec3(1, 1, 1), Vec3(1, 1, 0), Vec3(1, 0, 1), Vec3(0, 1, 1)}) {
      const Vec3 p =
          (share[0] * mesh.corner(t, 0) + share[1] * mesh.corner(t, 1) + share[2] * mesh.corner(t, 2)) / share.sum();
      most = std::max(most, std::abs(distance(p).distance));
    }
  return most;
}

TriangleMesh without_far_side(const TriangleMesh& mesh, const Vec3& towards, double share) {
  std::vector<std::size_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto facing = [&](std::size_t t) { return triangle_normal(mesh, t).dot(towards); };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return facing(a) < facing(b); });
  double gone = share * area(mesh);
  TriangleMesh left;
  left.vertices = mesh.vertices;
  for (const std::size_t t : order) {
    const double size =
        0.5 * (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
    gone -= size;
    if (gone + size / 2 < 0) left.triangles.push_back(mesh.triangles[t]);
  }
  return welded(left, 0);
}

}  // namespace partscribe::testing::recovery
