#include "model/distance.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/ensure.h"
#include "core/number.h"
#include "geometry/mesh/convex.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/surfaces/quadric_distance.h"
#include "model/lower.h"
#include "model/overloaded.h"
#include "model/sketch.h"

namespace partscribe::model {
namespace {

/// The nearest place of one shape in its own frame; `face` counts the shape's own faces.
struct LocalHit {
  double distance;
  int face;
};

class Solid {
 public:
  virtual ~Solid() = default;
  virtual LocalHit hit(const Vec3& p) const = 0;
  std::vector<std::string> faces;  // names of the shape's faces
};

/// A plane figure moved along z (extruded) or turned about it (revolved).
class Swept : public Solid {
 public:
  Swept(const EvaluatedSketch& sketch, bool revolved, double height)
      : outline_(outline_of(sketch)), revolved_(revolved), height_(height) {
    const auto& curves = outline_.outline().curves;
    for (std::size_t i = 0; i < curves.size(); ++i) {
      faces.push_back(curves[i].name);
      const auto* line = std::get_if<Line2>(&curves[i].curve);
      // A profile's edge on the axis bounds the plane figure, not the solid.
      if (revolved && line && std::abs(line->a.x()) < 1e-9 && std::abs(line->b.x()) < 1e-9)
        outline_.ignore(static_cast<int>(i));
    }
    if (!revolved) faces.push_back("bottom"), faces.push_back("top");
  }
  LocalHit hit(const Vec3& p) const override {
    if (revolved_) {
      const auto h = outline_(Vec2(std::hypot(p.x(), p.y()), p.z()));
      return {h.distance, h.curve};
    }
    const auto h = outline_(p.head<2>());
    const double below = -p.z(), above = p.z() - height_;
    const double end = std::max(below, above);
    const int end_face = static_cast<int>(faces.size()) - (below >= above ? 2 : 1);
    if (h.distance <= 0 && end <= 0) return h.distance >= end ? LocalHit{h.distance, h.curve} : LocalHit{end, end_face};
    if (h.distance > 0 && end > 0) return {std::hypot(h.distance, end), h.distance >= end ? h.curve : end_face};
    return h.distance > 0 ? LocalHit{h.distance, h.curve} : LocalHit{end, end_face};
  }

 private:
  OutlineDistance outline_;
  bool revolved_;
  double height_;
};

class MeshSolid : public Solid {
 public:
  MeshSolid(TriangleMesh mesh, std::vector<int> face_of, std::vector<std::string> names, bool closed)
      : mesh_(std::make_unique<TriangleMesh>(std::move(mesh))),
        distance_(*mesh_),
        face_of_(std::move(face_of)),
        closed_(closed) {
    faces = std::move(names);
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

/// A convex body: the planes answer inside, the polyhedron's mesh outside.
class ConvexSolid : public Solid {
 public:
  ConvexSolid(std::vector<Plane3> planes, std::vector<std::string> names) : planes_(std::move(planes)) {
    faces = std::move(names);
    std::vector<int> face_of;
    if (const auto body = convex_polyhedron(planes_)) {
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

 private:
  std::vector<Plane3> planes_;
  std::unique_ptr<MeshSolid> outside_;
};

template <class F>
class FunctionSolid : public Solid {
 public:
  FunctionSolid(std::string name, F function) : function_(std::move(function)) { faces = {std::move(name)}; }
  LocalHit hit(const Vec3& p) const override { return {function_(p), 0}; }

 private:
  F function_;
};

template <class F>
std::unique_ptr<Solid> function_solid(std::string name, F function) {
  return std::make_unique<FunctionSolid<F>>(std::move(name), std::move(function));
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

SolidPointer make_solid(const BoxOf<double>& s) {
  return std::make_unique<ConvexSolid>(planes_of(s.size_x, s.size_y, s.size_z), box_names);
}

SolidPointer make_solid(const WedgeOf<double>& s) {
  auto planes = planes_of(s.size_x, s.size_y, s.size_z);
  const Vec3 n = Vec3(s.size_y, s.size_x - s.top_x, 0).normalized();
  planes[1] = {n, n.x() * s.size_x};
  auto names = box_names;
  names[1] = "slope";
  if (s.top_x <= 0) planes.erase(planes.begin() + 3), names.erase(names.begin() + 3);
  return std::make_unique<ConvexSolid>(planes, names);
}

SolidPointer make_solid(const CylinderOf<double>& s) {
  return std::make_unique<Swept>(
      profile({{{0, 0}, "bottom"}, {{s.radius, 0}, "side"}, {{s.radius, s.height}, "top"}, {{0, s.height}, "axis"}}),
      true, 0);
}

SolidPointer make_solid(const ConeOf<double>& s) {
  std::vector<std::pair<Vec2, std::string>> corners = {{{0, 0}, "bottom"}};
  if (s.bottom_radius > 0)
    corners.push_back({{s.bottom_radius, 0}, "side"});
  else
    corners.back().second = "side";
  if (s.top_radius > 0) corners.push_back({{s.top_radius, s.height}, "top"});
  corners.push_back({{0, s.height}, "axis"});
  return std::make_unique<Swept>(profile(corners), true, 0);
}

SolidPointer make_solid(const SphereOf<double>& s) {
  return function_solid("surface", [r = s.radius](const Vec3& p) { return p.norm() - r; });
}

SolidPointer make_solid(const EllipsoidOf<double>& s) {
  return function_solid(
      "surface", [r = Vec3(s.radius_x, s.radius_y, s.radius_z)](const Vec3& p) { return ellipsoid_distance(p, r); });
}

SolidPointer make_solid(const TorusOf<double>& s) {
  return function_solid("surface", [R = s.major_radius, r = s.minor_radius](const Vec3& p) {
    return std::hypot(std::hypot(p.x(), p.y()) - R, p.z()) - r;
  });
}

SolidPointer make_solid(const SuperellipsoidOf<double>& s) {
  return function_solid("surface", [q = s](const Vec3& p) {
    return superellipsoid_distance(p, q.a1, q.a2, q.a3, q.e1, q.e2, q.taper_x, q.taper_y);
  });
}

SolidPointer make_solid(const SupertoroidOf<double>& s) {
  return function_solid("surface", [q = s](const Vec3& p) {
    return supertoroid_distance(p, q.major_radius, q.minor_radius, q.half_height, q.e1, q.e2);
  });
}

SolidPointer make_solid(const ExtrudeOf<double>& s) { return std::make_unique<Swept>(s.sketch, false, s.height); }

SolidPointer make_solid(const FilletOf<double>& s) { return make_solid(lowered(s)); }

SolidPointer make_solid(const RevolveOf<double>& s) { return std::make_unique<Swept>(s.sketch, true, 0); }

SolidPointer make_solid(const HalfSpacesOf<double>& s) {
  std::vector<Plane3> planes;
  std::vector<std::string> names;
  for (const auto& p : s.planes) {
    const Vec3 n(p.normal_x, p.normal_y, p.normal_z);
    planes.push_back({n.normalized(), p.offset});
    names.push_back(p.name.empty() ? "face " + print_number(double(planes.size())) : p.name);
  }
  return std::make_unique<ConvexSolid>(planes, names);
}

SolidPointer make_solid(const TriSurfaceOf<double>& s) {
  TriangleMesh mesh;
  for (const auto& v : s.vertices) mesh.vertices.emplace_back(v[0], v[1], v[2]);
  mesh.triangles = s.triangles;
  return std::make_unique<MeshSolid>(std::move(mesh), std::vector<int>{}, std::vector<std::string>{"surface"},
                                     s.closed);
}

}  // namespace

struct ModelDistance::Node {
  enum class Op { leaf, join, cut, common } op = Op::leaf;
  Pose object_from_part;  // the frame's inverse
  std::shared_ptr<const Solid> solid;
  std::vector<int> face_ids;  // of the solid's faces in the model's list
  std::vector<std::shared_ptr<const Node>> operands;

  ModelHit hit(const Vec3& p_part) const {
    const Vec3 p = object_from_part * p_part;
    if (op == Op::leaf) {
      const LocalHit h = solid->hit(p);
      return {h.distance, face_ids[static_cast<std::size_t>(h.face)]};
    }
    ModelHit best = operands[0]->hit(p);
    for (std::size_t i = 1; i < operands.size(); ++i) {
      ModelHit other = operands[i]->hit(p);
      if (op == Op::cut) other.distance = -other.distance;
      if (op == Op::join ? other.distance < best.distance : other.distance > best.distance) best = other;
    }
    return best;
  }
};

ModelDistance::ModelDistance(const Model& model, const Values& values) {
  ensure(!model.objects.empty(), "a model has an object");
  std::map<std::string, std::shared_ptr<const Node>> nodes;
  std::set<std::string> taken;
  const bool single = model.objects.size() == 1;
  for (const auto& object : model.objects) {
    auto node = std::make_shared<Node>();
    const EvaluatedShape shape = evaluate(object.shape, values);
    node->object_from_part = evaluate(object.frame, values).inverse();
    const auto combine = [&](Node::Op op, const std::vector<std::string>& names) {
      node->op = op;
      for (const auto& name : names) node->operands.push_back(nodes.at(name));
    };
    std::visit(Overloaded{[&](const UnionOf<double>& s) { combine(Node::Op::join, s.objects); },
                          [&](const DifferenceOf<double>& s) { combine(Node::Op::cut, s.objects); },
                          [&](const IntersectionOf<double>& s) { combine(Node::Op::common, s.objects); },
                          [&](const auto& s) { node->solid = make_solid(s); }},
               shape);
    if (node->solid)
      for (const auto& name : node->solid->faces) {
        const std::string base = single ? name : object.name + " " + name;
        std::string full = base;
        for (int k = 2; !taken.insert(full).second; ++k) full = base + " " + print_number(k);
        node->face_ids.push_back(static_cast<int>(faces_.size()));
        faces_.push_back({full, object.name});
      }
    nodes[object.name] = node;
  }
  root_ = std::make_unique<Node>(*nodes.at(model.objects.back().name));
  if (model.as_scanned) part_from_scan_ = evaluate(model.scan_from_part, values).inverse();
}

ModelDistance::ModelDistance(const Model& model) : ModelDistance(model, values_of(model)) {}
ModelDistance::~ModelDistance() = default;
ModelDistance::ModelDistance(ModelDistance&&) noexcept = default;

ModelHit ModelDistance::operator()(const Vec3& point) const { return root_->hit(part_from_scan_ * point); }
const std::vector<ModelFace>& ModelDistance::faces() const { return faces_; }

}  // namespace partscribe::model
