#include "model/distance/solids.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/ensure.h"
#include "core/number.h"
#include "geometry/mesh/convex.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/surfaces/quadric_distance.h"
#include "model/distance/drafted.h"
#include "model/lower/lower.h"
#include "model/overloaded.h"
#include "model/sketch.h"
#include "model/surface_patches.h"
#include "model/tri_faces.h"

namespace partscribe::model {
namespace {

/// The sketch moved along z.
class Extruded : public Solid {
 public:
  explicit Extruded(const ExtrudeOf<double>& s) : outline_(outline_of(s.sketch)), low_(-s.below), high_(s.height) {
    for (const auto& curve : outline_.outline().curves) faces.push_back(curve.name);
    faces.push_back("bottom"), faces.push_back("top");
    bounds = flat_box(outline_.outline());
    bounds.low.z() = low_, bounds.high.z() = high_;
  }
  LocalHit hit(const Vec3& p) const override {
    const auto h = outline_(p.head<2>());
    const double below = low_ - p.z(), above = p.z() - high_;
    const double end = std::max(below, above);
    const int end_face = static_cast<int>(faces.size()) - (below >= above ? 2 : 1);
    if (h.distance <= 0 && end <= 0) return h.distance >= end ? LocalHit{h.distance, h.curve} : LocalHit{end, end_face};
    if (h.distance > 0 && end > 0) return {std::hypot(h.distance, end), h.distance >= end ? h.curve : end_face};
    return h.distance > 0 ? LocalHit{h.distance, h.curve} : LocalHit{end, end_face};
  }
  Foot foot(const Vec3& p, int face) const override {
    const int walls = static_cast<int>(faces.size()) - 2;
    const Vec2 flat = p.head<2>();
    Foot f;
    if (face < walls) {
      const auto on_curve = outline_.foot(flat, face);
      f.point << on_curve.point, std::clamp(p.z(), low_, high_);
      f.normal << on_curve.normal, 0;
    } else {
      f.point << (outline_.inside(flat) ? flat : outline_(flat).foot), face == walls ? low_ : high_;
    }
    f.distance = (p - f.point).norm();
    return f;
  }

 private:
  OutlineDistance outline_;
  double low_, high_;
};

/// The sketch (radius, z) turned about z, by a full turn or from the plane y = 0 to the plane at `angle`.
class Revolved : public Solid {
 public:
  Revolved(const EvaluatedSketch& sketch, double angle) : outline_(outline_of(sketch)), angle_(angle) {
    if (angle <= 2 * pi - 1e-9) whole_.emplace(outline_.outline());
    const auto& curves = outline_.outline().curves;
    for (std::size_t i = 0; i < curves.size(); ++i) {
      faces.push_back(curves[i].name);
      const auto* line = std::get_if<Line2>(&curves[i].curve);
      // A profile's edge on the axis bounds the plane figure, not the solid.
      const bool on_axis = line && std::abs(line->a.x()) < 1e-9 && std::abs(line->b.x()) < 1e-9;
      if (on_axis) outline_.ignore(static_cast<int>(i));
      on_axis_.push_back(on_axis);
    }
    if (whole_) faces.push_back("start"), faces.push_back("end");
    const Box3 flat = flat_box(outline_.outline());
    bounds.low = Vec3(-flat.high.x(), -flat.high.x(), flat.low.y());
    bounds.high = Vec3(flat.high.x(), flat.high.x(), flat.high.y());
  }
  LocalHit hit(const Vec3& p) const override {
    const Vec2 q(std::hypot(p.x(), p.y()), p.z());
    if (!whole_) {
      const auto h = outline_(q);
      return {h.distance, h.curve};
    }
    const int walls = static_cast<int>(faces.size()) - 2;
    const bool between = azimuth(p) <= angle_;
    LocalHit best{1e300, walls};
    if (between) {
      const auto h = outline_(q);
      best = {std::abs(h.distance), h.curve};
    }
    for (const int end : {walls, walls + 1})
      if (const double d = foot(p, end).distance; d < best.distance) best = {d, end};
    if (between && whole_->inside(q)) best.distance = -best.distance;
    return best;
  }
  Foot foot(const Vec3& p, int face) const override {
    const int walls = static_cast<int>(faces.size()) - (whole_ ? 2 : 0);
    Foot f;
    if (face < walls) {
      if (on_axis_[static_cast<std::size_t>(face)]) return {1e300, p};
      double turn = std::atan2(p.y(), p.x());
      if (whole_ && azimuth(p) > angle_) turn = azimuth(p) - angle_ < 2 * pi - azimuth(p) ? angle_ : 0;
      const Vec3 out(std::cos(turn), std::sin(turn), 0);
      const auto on_curve = outline_.foot({out.dot(p), p.z()}, face);
      f.point = on_curve.point.x() * out + on_curve.point.y() * Vec3::UnitZ();
      f.normal = on_curve.normal.x() * out + on_curve.normal.y() * Vec3::UnitZ();
    } else {
      const double turn = face == walls ? 0 : angle_;
      const Vec3 out(std::cos(turn), std::sin(turn), 0);
      const Vec2 flat(out.dot(p), p.z());
      const Vec2 at = whole_->inside(flat) ? flat : (*whole_)(flat).foot;
      f.point = at.x() * out + at.y() * Vec3::UnitZ();
      f.normal = Vec3(-out.y(), out.x(), 0);
    }
    f.distance = (p - f.point).norm();
    return f;
  }

 private:
  static double azimuth(const Vec3& p) {
    const double a = std::atan2(p.y(), p.x());
    return a < 0 ? a + 2 * pi : a;
  }
  OutlineDistance outline_;               // without the edges on the axis
  std::optional<OutlineDistance> whole_;  // with them; for part of a turn, which has ends
  std::vector<char> on_axis_;
  double angle_;
};

class MeshSolid : public Solid {
 public:
  MeshSolid(TriangleMesh mesh, std::vector<int> face_of, std::vector<std::string> names, bool closed)
      : mesh_(std::make_unique<TriangleMesh>(std::move(mesh))),
        distance_(*mesh_),
        face_of_(std::move(face_of)),
        closed_(closed) {
    faces = std::move(names);
    for (const Vec3& v : mesh_->vertices) bounds.add(v);
  }
  Foot foot(const Vec3& p, int) const override {
    const MeshHit h = distance_.closest(p);
    return {(p - h.point).norm(), h.point, triangle_normal(*mesh_, h.triangle)};
  }
  LocalHit hit(const Vec3& p) const override {
    const MeshHit h = distance_.closest(p);
    double d = h.distance;
    if (closed_)
      d = std::copysign(d, distance_.signed_distance(p));
    else if ((p - h.point).dot(triangle_normal(*mesh_, h.triangle)) < 0)
      d = -d;
    return {d, face_of_.empty() ? 0 : face_of_[h.triangle]};
  }

 private:
  std::unique_ptr<TriangleMesh> mesh_;
  MeshDistance distance_;
  std::vector<int> face_of_;
  bool closed_;
};

/// Trimmed B-spline surfaces.
class SurfaceSolid : public Solid {
 public:
  explicit SurfaceSolid(const SurfaceSetOf<double>& s)
      : distance_(trimmed_surfaces(s.patches), edge_share * size_of(s), s.closed) {
    for (const auto& patch : s.patches) faces.push_back(patch.name);
    bounds = distance_.bounds();
  }
  LocalHit hit(const Vec3& p) const override {
    const auto h = distance_(p);
    return {h.distance, static_cast<int>(h.patch)};
  }
  Foot foot(const Vec3& p, int face) const override {
    const auto h = distance_.on(static_cast<std::uint32_t>(face), p);
    return {h.distance, h.point, h.normal};
  }

 private:
  static constexpr double edge_share = 5e-5;  // of the size: how far off distances to edges may be
  static double size_of(const SurfaceSetOf<double>& s) {
    Box3 box;
    for (const auto& patch : s.patches)
      for (const auto& p : patch.control) box.add(Vec3(p[0], p[1], p[2]));
    return box.diagonal();
  }
  SurfaceDistance distance_;
};

/// A convex body: the planes answer inside, the polyhedron's mesh outside.
class ConvexSolid : public Solid {
 public:
  ConvexSolid(std::vector<Plane3> planes, std::vector<std::string> names) : planes_(std::move(planes)) {
    faces = std::move(names);
    std::vector<int> face_of;
    if (const auto body = convex_polyhedron(planes_)) {
      for (const Vec3& v : body->vertices) bounds.add(v);
      for (const auto& face : body->faces) {
        polygons_.emplace_back();
        for (const auto v : face) polygons_.back().push_back(body->vertices[v]);
      }
      TriangleMesh mesh = triangulated(*body, &face_of);
      outside_ = std::make_unique<MeshSolid>(std::move(mesh), std::move(face_of), std::vector<std::string>{}, true);
    }
  }
  LocalHit hit(const Vec3& p) const override {
    LocalHit best{-1e300, 0};
    for (std::size_t i = 0; i < planes_.size(); ++i) {
      const double d = planes_[i].normal.dot(p) - planes_[i].offset;
      if (d > best.distance) best = {d, static_cast<int>(i)};
    }
    if (best.distance <= 0 || !outside_) return best;
    const LocalHit exact = outside_->hit(p);
    return {std::abs(exact.distance), exact.face};
  }
  Foot foot(const Vec3& p, int face) const override {
    const std::size_t i = static_cast<std::size_t>(face);
    const Vec3& n = planes_[i].normal;
    if (i >= polygons_.size() || polygons_[i].size() < 3) return {1e300, p, n};
    return foot_on_polygon(polygons_[i], n, p);
  }

 private:
  std::vector<std::vector<Vec3>> polygons_;  // per plane; empty where it does not touch the body
  std::vector<Plane3> planes_;
  std::unique_ptr<MeshSolid> outside_;
};

/// A solid with one smooth face, given by its signed distance.
template <class F>
class FunctionSolid : public Solid {
 public:
  FunctionSolid(const Box3& box, F function) : function_(std::move(function)) {
    faces = {"surface"};
    bounds = box;
    step_ = 0.5e-6 * box.size().maxCoeff();
  }
  LocalHit hit(const Vec3& p) const override { return {function_(p), 0}; }
  Foot foot(const Vec3& p, int) const override {
    const double d = function_(p);
    Foot f{std::abs(d), p, gradient(p)};
    // Once more from there: the slope is known to some nine digits only.
    f.point -= d * f.normal;
    f.point -= function_(f.point) * f.normal;
    return f;
  }

 private:
  Vec3 gradient(const Vec3& p) const {
    Vec3 g;
    for (int k = 0; k < 3; ++k) {
      const Vec3 h = step_ * Vec3::Unit(k);
      g[k] = function_(p + h) - function_(p - h);
    }
    const double length = g.norm();
    return length > 0 ? Vec3(g / length) : Vec3(0, 0, 1);
  }
  F function_;
  double step_;
};

template <class F>
std::unique_ptr<Solid> function_solid(const Box3& box, F function) {
  return std::make_unique<FunctionSolid<F>>(box, std::move(function));
}
template <class F>
std::unique_ptr<Solid> function_solid(const Vec3& half_size, F function) {
  Box3 box;
  box.add(-half_size), box.add(half_size);
  return function_solid(box, std::move(function));
}

EvaluatedSketch profile(std::vector<std::pair<Vec2, std::string>> corners) {
  LoopOf<double> loop;
  for (const auto& [p, edge] : corners) loop.elements.push_back(SketchPointOf<double>{p.x(), p.y(), edge});
  return {{loop}};
}

/// The planes of a block from the origin: left, right, front, back, bottom, top.
std::vector<Plane3> planes_of(double x, double y, double z) {
  return {{-Vec3::UnitX(), 0}, {Vec3::UnitX(), x},  {-Vec3::UnitY(), 0},
          {Vec3::UnitY(), y},  {-Vec3::UnitZ(), 0}, {Vec3::UnitZ(), z}};
}
const std::vector<std::string> box_names = {"left", "right", "front", "back", "bottom", "top"};

using SolidPointer = std::unique_ptr<Solid>;

SolidPointer solid_for(const BoxOf<double>& s) {
  return std::make_unique<ConvexSolid>(planes_of(s.size_x, s.size_y, s.size_z), box_names);
}

SolidPointer solid_for(const WedgeOf<double>& s) {
  auto planes = planes_of(s.size_x, s.size_y, s.size_z);
  const Vec3 n = Vec3(s.size_y, s.size_x - s.top_x, 0).normalized();
  planes[1] = {n, n.x() * s.size_x};
  auto names = box_names;
  names[1] = "slope";
  if (s.top_x <= 0) planes.erase(planes.begin() + 3), names.erase(names.begin() + 3);
  return std::make_unique<ConvexSolid>(planes, names);
}

SolidPointer solid_for(const CylinderOf<double>& s) {
  return std::make_unique<Revolved>(
      profile({{{0, 0}, "bottom"}, {{s.radius, 0}, "side"}, {{s.radius, s.height}, "top"}, {{0, s.height}, "axis"}}),
      2 * pi);
}

SolidPointer solid_for(const ConeOf<double>& s) {
  std::vector<std::pair<Vec2, std::string>> corners = {{{0, 0}, "bottom"}};
  if (s.bottom_radius > 0)
    corners.push_back({{s.bottom_radius, 0}, "side"});
  else
    corners.back().second = "side";
  if (s.top_radius > 0) corners.push_back({{s.top_radius, s.height}, "top"});
  corners.push_back({{0, s.height}, "axis"});
  return std::make_unique<Revolved>(profile(corners), 2 * pi);
}

SolidPointer solid_for(const SphereOf<double>& s) {
  return function_solid(Vec3::Constant(s.radius), [r = s.radius](const Vec3& p) { return p.norm() - r; });
}

SolidPointer solid_for(const EllipsoidOf<double>& s) {
  return function_solid(
      Vec3(s.radius_x, s.radius_y, s.radius_z),
      [r = Vec3(s.radius_x, s.radius_y, s.radius_z)](const Vec3& p) { return ellipsoid_distance(p, r); });
}

SolidPointer solid_for(const TorusOf<double>& s) {
  const double reach = s.major_radius + s.minor_radius;
  return function_solid(Vec3(reach, reach, s.minor_radius), [R = s.major_radius, r = s.minor_radius](const Vec3& p) {
    return std::hypot(std::hypot(p.x(), p.y()) - R, p.z()) - r;
  });
}

SolidPointer solid_for(const SuperellipsoidOf<double>& s) {
  if (s.bend != 0) {
    BentSuperellipsoid body(s.a1, s.a2, s.a3, s.e1, s.e2, s.taper_x, s.taper_y, s.bend);
    const Box3 box = body.bounds();
    return function_solid(box, [b = std::move(body)](const Vec3& p) { return b.distance(p); });
  }
  const Vec3 half(s.a1 * (1 + std::abs(s.taper_x)), s.a2 * (1 + std::abs(s.taper_y)), s.a3);
  return function_solid(half, [q = s](const Vec3& p) {
    return superellipsoid_distance(p, q.a1, q.a2, q.a3, q.e1, q.e2, q.taper_x, q.taper_y);
  });
}

SolidPointer solid_for(const SupertoroidOf<double>& s) {
  const double reach = s.major_radius + s.minor_radius;
  return function_solid(Vec3(reach, reach, s.half_height), [q = s](const Vec3& p) {
    return supertoroid_distance(p, q.major_radius, q.minor_radius, q.half_height, q.e1, q.e2);
  });
}

SolidPointer solid_for(const ExtrudeOf<double>& s) {
  return s.draft == 0 ? std::make_unique<Extruded>(s) : drafted_solid(s);
}

SolidPointer solid_for(const RevolveOf<double>& s) { return std::make_unique<Revolved>(s.sketch, s.angle); }

SolidPointer solid_for(const HalfSpacesOf<double>& s) {
  std::vector<Plane3> planes;
  std::vector<std::string> names;
  for (const auto& p : s.planes) {
    const Vec3 n(p.normal_x, p.normal_y, p.normal_z);
    planes.push_back({n.normalized(), p.offset});
    names.push_back(p.name.empty() ? "face " + print_number(double(planes.size())) : p.name);
  }
  return std::make_unique<ConvexSolid>(planes, names);
}

SolidPointer solid_for(const TriSurfaceOf<double>& s) {
  TriangleMesh mesh;
  for (const auto& v : s.vertices) mesh.vertices.emplace_back(v[0], v[1], v[2]);
  mesh.triangles = s.triangles;
  if (s.faces.empty())
    return std::make_unique<MeshSolid>(std::move(mesh), std::vector<int>{}, std::vector<std::string>{"surface"},
                                       s.closed);
  const auto face_of = faces_of_triangles(s);
  std::vector<std::string> names;
  for (const auto& face : s.faces) names.push_back(face.name);
  return std::make_unique<MeshSolid>(std::move(mesh), std::vector<int>(face_of.begin(), face_of.end()),
                                     std::move(names), s.closed);
}

SolidPointer solid_for(const SurfaceSetOf<double>& s) { return std::make_unique<SurfaceSolid>(s); }

SolidPointer solid_for(const UnionOf<double>&) { return {}; }
SolidPointer solid_for(const DifferenceOf<double>&) { return {}; }
SolidPointer solid_for(const IntersectionOf<double>&) { return {}; }

template <LoweredAway S>
SolidPointer solid_for(const S&) {
  ensure(false, "features are lowered before they are measured");
  return {};
}

}  // namespace

Foot foot_on_polygon(std::span<const Vec3> corners, const Vec3& normal, const Vec3& p) {
  Foot f{1e300, p, normal};
  const Vec3 q = p - normal.dot(p - corners[0]) * normal;
  bool inside = true;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vec3 &a = corners[k], &b = corners[(k + 1) % corners.size()], along = b - a;
    if (normal.dot(along.cross(q - a)) >= 0) continue;
    inside = false;
    const double t = std::clamp((q - a).dot(along) / std::max(along.squaredNorm(), 1e-300), 0.0, 1.0);
    const Vec3 at = a + t * along;
    if (const double d = (p - at).norm(); d < f.distance) f.distance = d, f.point = at;
  }
  if (inside) f.distance = (p - q).norm(), f.point = q;
  return f;
}

std::unique_ptr<Solid> make_solid(const EvaluatedShape& shape) {
  return std::visit([](const auto& s) { return solid_for(s); }, shape);
}

}  // namespace partscribe::model
