/// Meshes and models as surfaces that rays can meet.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <map>
#include <memory>

#include "geometry/mesh/mesh_distance.h"
#include "model/distance/distance.h"
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
constexpr double near_surface = 1e-3;      // mm; farther away a bound will do
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
  const Box3 safe = distance->bounds();
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
    const auto along = [&](double t) {
      const Vec3 p = origin + t * direction;
      const double at_least = distance->bound(p);
      return at_least > near_surface ? at_least : (*distance)(p).distance;
    };
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
