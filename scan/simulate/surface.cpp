/// Meshes and models as surfaces that rays can meet.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <map>
#include <memory>

#include "geometry/mesh/mesh_distance.h"
#include "model/distance.h"
#include "model/sketch.h"
#include "scan/simulate/simulate.h"

namespace partscribe::scan {
namespace {

struct MeshAndTree {
  TriangleMesh mesh;
  MeshDistance tree;
  explicit MeshAndTree(const TriangleMesh& m) : mesh(m), tree(mesh) {}
};

// ---- a box around a model -------------------------------------------------------------------------------------

Box3 symmetric(double x, double y, double low, double high) {
  Box3 box;
  box.add(Vec3(-x, -y, low)), box.add(Vec3(x, y, high));
  return box;
}

struct Box2 {
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity());
  Vec2 high = -low;
  void add(const Vec2& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
};

Box2 box_of(const EvaluatedSketch& sketch) {
  Box2 box;
  for (const auto& item : outline_of(sketch).curves) {
    if (const auto* line = std::get_if<Line2>(&item.curve)) {
      box.add(line->a), box.add(line->b);
    } else if (const auto* arc = std::get_if<Arc2>(&item.curve)) {
      box.add(arc->center - Vec2::Constant(arc->radius)), box.add(arc->center + Vec2::Constant(arc->radius));
    } else if (const auto* nurbs = std::get_if<Nurbs2>(&item.curve)) {
      for (const auto& p : nurbs->control) box.add(p);  // a curve stays in the hull of its control points
    }
  }
  return box;
}

/// Corners of the polyhedron: where three planes meet and no other cuts the place off.
Box3 box_of(const HalfSpacesOf<double>& shape) {
  Box3 box;
  const auto& planes = shape.planes;
  double scale = 1;
  for (const auto& p : planes) scale = std::max(scale, std::abs(p.offset));
  for (std::size_t i = 0; i < planes.size(); ++i)
    for (std::size_t j = i + 1; j < planes.size(); ++j)
      for (std::size_t k = j + 1; k < planes.size(); ++k) {
        Mat3 A;
        Vec3 b;
        int row = 0;
        for (const auto* p : {&planes[i], &planes[j], &planes[k]}) {
          A.row(row) = Vec3(p->normal_x, p->normal_y, p->normal_z).transpose();
          b[row++] = p->offset;
        }
        if (std::abs(A.determinant()) < 1e-9) continue;
        const Vec3 corner = A.inverse() * b;
        bool inside = true;
        for (const auto& p : planes)
          inside = inside && corner.dot(Vec3(p.normal_x, p.normal_y, p.normal_z)) <= p.offset + 1e-7 * scale;
        if (inside) box.add(corner);
      }
  return box;
}

/// A box of one object in its own frame; `boxes` holds those of earlier objects in the frame of their parent.
struct ShapeBox {
  const std::map<std::string, Box3>& boxes;
  Box3 operator()(const BoxOf<double>& s) const {
    Box3 box;
    box.add(Vec3(0, 0, 0)), box.add(Vec3(s.size_x, s.size_y, s.size_z));
    return box;
  }
  Box3 operator()(const WedgeOf<double>& s) const {
    Box3 box;
    box.add(Vec3(0, 0, 0)), box.add(Vec3(std::max(s.size_x, s.top_x), s.size_y, s.size_z));
    return box;
  }
  Box3 operator()(const CylinderOf<double>& s) const { return symmetric(s.radius, s.radius, 0, s.height); }
  Box3 operator()(const ConeOf<double>& s) const {
    const double r = std::max(s.bottom_radius, s.top_radius);
    return symmetric(r, r, 0, s.height);
  }
  Box3 operator()(const SphereOf<double>& s) const { return symmetric(s.radius, s.radius, -s.radius, s.radius); }
  Box3 operator()(const EllipsoidOf<double>& s) const {
    return symmetric(s.radius_x, s.radius_y, -s.radius_z, s.radius_z);
  }
  Box3 operator()(const TorusOf<double>& s) const {
    const double r = s.major_radius + s.minor_radius;
    return symmetric(r, r, -s.minor_radius, s.minor_radius);
  }
  Box3 operator()(const SuperellipsoidOf<double>& s) const {
    return symmetric(s.a1 * (1 + std::abs(s.taper_x)), s.a2 * (1 + std::abs(s.taper_y)), -s.a3, s.a3);
  }
  Box3 operator()(const SupertoroidOf<double>& s) const {
    const double r = s.major_radius + s.minor_radius;
    return symmetric(r, r, -s.half_height, s.half_height);
  }
  Box3 operator()(const FilletOf<double>& s) const {
    Box3 box;
    box.add(Vec3(0, 0, 0)), box.add(Vec3(s.width, s.height, s.length));
    return box;
  }
  Box3 operator()(const HalfSpacesOf<double>& s) const { return box_of(s); }
  Box3 operator()(const ExtrudeOf<double>& s) const {
    const auto flat = box_of(s.sketch);
    Box3 box;
    box.add(Vec3(flat.low.x(), flat.low.y(), 0)), box.add(Vec3(flat.high.x(), flat.high.y(), s.height));
    return box;
  }
  Box3 operator()(const RevolveOf<double>& s) const {
    const auto profile = box_of(s.sketch);
    return symmetric(profile.high.x(), profile.high.x(), profile.low.y(), profile.high.y());
  }
  Box3 operator()(const TriSurfaceOf<double>& s) const {
    Box3 box;
    for (const auto& v : s.vertices) box.add(Vec3(v[0], v[1], v[2]));
    return box;
  }
  Box3 operator()(const UnionOf<double>& s) const {
    Box3 box;
    for (const auto& name : s.objects) {
      const auto& other = boxes.at(name);
      box.low = box.low.cwiseMin(other.low), box.high = box.high.cwiseMax(other.high);
    }
    return box;
  }
  Box3 operator()(const DifferenceOf<double>& s) const { return boxes.at(s.objects.front()); }
  Box3 operator()(const IntersectionOf<double>& s) const {
    Box3 box = boxes.at(s.objects.front());
    for (const auto& name : s.objects) {
      const auto& other = boxes.at(name);
      box.low = box.low.cwiseMax(other.low), box.high = box.high.cwiseMin(other.high);
    }
    return box;
  }
};

Box3 transformed(const Box3& box, const Pose& pose) {
  Box3 result;
  if (box.empty()) return result;
  for (int c = 0; c < 8; ++c)
    result.add(pose * Vec3(c & 1 ? box.high.x() : box.low.x(), c & 2 ? box.high.y() : box.low.y(),
                           c & 4 ? box.high.z() : box.low.z()));
  return result;
}

/// A box that certainly holds the model; often too large, because corners are turned and cuts ignored.
Box3 safe_box(const Model& model) {
  const auto values = values_of(model);
  std::map<std::string, Box3> boxes;
  Box3 last;
  for (const auto& object : model.objects) {
    last = transformed(std::visit(ShapeBox{boxes}, evaluate(object.shape, values)), evaluate(object.frame, values));
    boxes[object.name] = last;
  }
  return model.as_scanned ? transformed(last, evaluate(model.scan_from_part, values)) : last;
}

/// Adds the parts of `cell` that the exact distance cannot rule out.
void tighten(const ModelDistance& distance, const Vec3& center, const Vec3& half, int depth, Box3& box) {
  const double d = distance(center).distance, reach = half.norm();
  if (d > reach) return;
  const Vec3 low = center - half, high = center + half;
  if ((low.array() >= box.low.array()).all() && (high.array() <= box.high.array()).all()) return;
  if (depth == 0 || d < -reach) {
    box.add(low), box.add(high);
    return;
  }
  for (int c = 0; c < 8; ++c) {
    const Vec3 side(c & 1 ? 0.5 : -0.5, c & 2 ? 0.5 : -0.5, c & 4 ? 0.5 : -0.5);
    tighten(distance, center + half.cwiseProduct(side), 0.5 * half, depth - 1, box);
  }
}

// ---- rays -----------------------------------------------------------------------------------------------------

constexpr double surface_reached = 1e-10;  // mm
constexpr int most_steps = 20'000;

/// Illinois false position between a place outside and one inside.
double crossing(const std::function<double(double)>& distance, double out, double d_out, double in, double d_in) {
  for (int i = 0; i < 100 && in - out > 1e-12 * (1 + std::abs(in)); ++i) {
    const double t = i % 3 == 2 ? 0.5 * (out + in) : (out * d_in - in * d_out) / (d_in - d_out);
    const double d = distance(t);
    if (std::abs(d) < 1e-13) return t;
    if (d > 0) {
      if (d_out > 0) d_in *= 0.5;
      out = t, d_out = d;
    } else {
      in = t, d_in = d;
    }
  }
  return 0.5 * (out + in);
}

/// Sphere tracing: the distance is a step that cannot cross the surface.
std::optional<double> trace(const std::function<double(double)>& distance, double from, double to) {
  double t = from, d = distance(t);
  if (d < 0) return {};
  double t_before = t, d_before = d;
  for (int i = 0; i < most_steps && t <= to; ++i) {
    if (d < surface_reached) return t;
    double step = d;
    // Near the surface, where steps shrink in proportion, the slope tells where it is.
    if (d < 1e-3 && t > t_before) {
      const double slope = (d_before - d) / (t - t_before);
      if (slope > 0.02) step = 1.01 * d / slope + 1e-11;
    }
    t_before = t, d_before = d;
    t += step;
    d = distance(t);
    if (d < 0) return crossing(distance, t_before, d_before, t, d);
  }
  return {};
}

}  // namespace

Surface surface_of(const TriangleMesh& mesh) {
  auto shared = std::make_shared<MeshAndTree>(mesh);
  Surface surface;
  surface.bounds = mesh.bounds();
  surface.first_hit = [shared](const Vec3& origin, const Vec3& direction) -> std::optional<SurfaceHit> {
    const auto hit = shared->tree.first_hit(origin, direction, std::numeric_limits<double>::infinity());
    if (!hit) return {};
    Vec3 normal = triangle_normal(shared->mesh, hit->triangle);
    if (normal.dot(direction) > 0) normal = -normal;  // an open mesh shows its back too
    return SurfaceHit{hit->distance, normal};
  };
  return surface;
}

Surface surface_of(const Model& model) {
  auto distance = std::make_shared<ModelDistance>(model);
  Surface surface;
  const Box3 safe = safe_box(model);
  if (!safe.empty()) tighten(*distance, safe.center(), 0.5 * safe.size(), 6, surface.bounds);
  const Vec3 center = surface.bounds.empty() ? Vec3(0, 0, 0) : surface.bounds.center();
  const double radius = 0.5 * surface.bounds.diagonal() * 1.001 + 1e-6;
  surface.first_hit = [distance, center, radius](const Vec3& origin,
                                                 const Vec3& direction) -> std::optional<SurfaceHit> {
    const double nearest = (center - origin).dot(direction);
    const double off = (origin + nearest * direction - center).squaredNorm();
    if (off > radius * radius) return {};
    const double half = std::sqrt(radius * radius - off);
    if (nearest + half <= 0) return {};
    const auto along = [&](double t) { return (*distance)(origin + t * direction).distance; };
    const auto t = trace(along, std::max(0.0, nearest - half), nearest + half);
    if (!t) return {};
    const Vec3 p = origin + *t * direction;
    const double h = 1e-6 * radius;
    Vec3 gradient;
    for (int k = 0; k < 3; ++k)
      gradient[k] = (*distance)(p + h * Vec3::Unit(k)).distance - (*distance)(p - h * Vec3::Unit(k)).distance;
    const double length = gradient.norm();
    return SurfaceHit{*t, length > 0 ? Vec3(gradient / length) : Vec3(-direction)};
  };
  return surface;
}

}  // namespace partscribe::scan
