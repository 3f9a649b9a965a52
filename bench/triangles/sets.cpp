#include "bench/triangles/sets.h"

#include <algorithm>
#include <cmath>

#include "bench/triangles/contour.h"
#include "geometry/io/read_geometry.h"
#include "geometry/mesh/mesh_repair.h"
#include "testing/relief_fields.h"

namespace bench {
namespace {

using partscribe::core::Result;
using partscribe::testing::relief_mesh;

/// A manifold mesh as it is: holes stay open.
TriangleMesh manifold(const TriangleMesh& mesh) {
  RepairOptions options;
  options.hole_area = 0, options.small_hole = 0, options.flat_hole = 0;
  return repair(mesh, options).mesh;
}

TriangleSet made(const std::string& name, const TriangleMesh& mesh, double tolerance) {
  return {name, manifold(mesh), tolerance, tolerance, {}, {}};
}

double smaller(double a, double b, double round) {  // joined, the corner between them rounded by a quartic
  const double h = std::max(round - std::abs(a - b), 0.0) / round;
  return std::min(a, b) - h * h * h * (4 - h) * round / 16;
}

/// Two solids joined with a hollow round of `radius` where they meet.
double joined_with_fillet(double a, double b, double radius) {
  const double u = std::max(radius - a, 0.0), v = std::max(radius - b, 0.0);
  return std::max(radius, std::min(a, b)) - std::hypot(u, v);
}

/// What two solids share, its edge rounded by `radius`.
double shared_with_round(double a, double b, double radius) {
  const double u = std::max(radius + a, 0.0), v = std::max(radius + b, 0.0);
  return std::min(-radius, std::max(a, b)) + std::hypot(u, v);
}

double rounded_box(const Vec3& p, const Vec3& half, double radius) {
  const Vec3 q = p.cwiseAbs() - half + Vec3::Constant(radius);
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0) - radius;
}

double upright_rod(const Vec3& p, double x, double y, double radius) {
  return std::hypot(p.x() - x, p.y() - y) - radius;
}

/// A piece of a fan: a ring's sector under a dome with a rounded blade, a chamfered boss, two holes; edges are sharp
/// but those of the blade and two others.
double fan_piece(const Vec3& p) {
  const double out = std::hypot(p.x(), p.y());
  const double side = std::sin(0.7) * p.y() - std::cos(0.7) * std::abs(p.x());
  const double rim = out - 54, inner = 17 - out, bottom = -p.z();
  const double dome = (p - Vec3(0, 30, -74)).norm() - 90;
  double part = std::max({shared_with_round(rim, dome, 3), shared_with_round(bottom, inner, 2), -side});
  const double blade = rounded_box(p - Vec3(-3, 36, 18), Vec3(3, 13, 10), 2.2);
  part = joined_with_fillet(part, blade, 2.5);
  const double boss = upright_rod(p, 20, 38, 7), top = p.z() - 22, low = 8 - p.z();
  part = std::min(part, std::max({boss, top, low, (boss + top) * std::sqrt(0.5) + 1.0}));
  const double bore = upright_rod(p, 20, 38, 3.5), sunk = (bore - top - 1.6) * std::sqrt(0.5);
  part = std::max({part, -bore, -sunk});
  return shared_with_round(part, -upright_rod(p, -19, 38, 4.5), 1.2);
}

double capsule(const Vec3& p, const Vec3& a, const Vec3& b, double ra, double rb) {
  const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - t * (b - a)).norm() - ra - t * (rb - ra);
}

/// A rocker arm: three eyes with bores, arms and a rib between them, all flowing into each other.
double rocker(const Vec3& p) {
  struct Eye {
    double x, y, outer, inner, half;
  };
  constexpr Eye eyes[3] = {{0, 0, 17, 9, 13}, {58, 6, 12, 6, 9}, {-40, 24, 10, 4.5, 8}};
  double part = 1e9;
  for (const Eye& e : eyes) {
    const double ring = shared_with_round(upright_rod(p, e.x, e.y, e.outer), std::abs(p.z()) - e.half, 3);
    part = smaller(part, ring, 7);
  }
  part = smaller(part, capsule(p, Vec3(0, 0, 0), Vec3(58, 6, 0), 9, 6), 9);
  part = smaller(part, capsule(p, Vec3(0, 0, 0), Vec3(-40, 24, 0), 8, 5.5), 9);
  part = smaller(part, capsule(p, Vec3(-30, 20, 6), Vec3(45, 10, 7), 3, 2.4), 5);
  // A window through the long arm, bores through the eyes; their rims are rounded too.
  const double window = capsule(Vec3(p.x(), p.y(), 0), Vec3(26, 1, 0), Vec3(38, 2.4, 0), 3.2, 2.6);
  part = -smaller(-part, window, 3);
  for (const Eye& e : eyes) part = -smaller(-part, upright_rod(p, e.x, e.y, e.inner), 2.5);
  return part;
}

/// z = height(x, y) on the unit square, which bends by `curvature` (the root of the absolute Gaussian one, in 1/mm).
template <class Height>
TriangleSet unit_square(const std::string& name, const Height& height, double curvature, bool saddle) {
  TriangleSet set = made(name, relief_mesh(height, {0, 0}, {1, 1}, 256, 256), 5e-5);
  // A bend of 0.2 strays from its chord by 2.5e-8 between places so far apart.
  set.spacing = 1e-3;
  // Largest triangles that interpolate a quadratic within t have 2.60 t / sqrt(K) where it is convex, 4.47 t / sqrt(-K)
  // on a saddle; leaving a convex surface halves their number. The slope is neglected: 1.5 % here.
  set.least = curvature / ((saddle ? 2 * std::sqrt(5.0) : 1.5 * std::sqrt(3.0)) * set.tolerance);
  if (!saddle) set.least_free = *set.least / 2;
  return set;
}

/// `factor` to mm; the tolerance is `share` of the longest side, or if that is 0 it is `tolerance`.
Result<TriangleSet> from_file(const std::string& name, const std::string& path, double factor, double share,
                              double tolerance) {
  partscribe::core::Context context;
  auto raw = read_geometry(path, context);
  if (!raw.ok()) return raw.error();
  for (Vec3& v : raw->mesh.vertices) v *= factor;
  if (raw->mesh.empty()) return partscribe::core::Error{path + ": expected triangles, found none"};
  const TriangleMesh mesh = manifold(raw->mesh);
  return made(name, mesh, share > 0 ? share * mesh.bounds().size().maxCoeff() : tolerance);
}

}  // namespace

const std::vector<SetMaker>& set_makers() {
  using namespace partscribe::testing;
  static const std::vector<SetMaker> makers = {
      {"face", "face",
       [](const std::string& path) -> Result<TriangleSet> { return from_file("face", path, 1000, 0, 0.5); }},
      {"face mask", "",
       [](const std::string&) -> Result<TriangleSet> {
         return made("face mask", relief_mesh(face_mask_height, {-76, -100}, {76, 100}, 256, 337), 0.5);
       }},
      {"hand", "",
       [](const std::string&) -> Result<TriangleSet> {
         return made("hand", relief_mesh(hand_height, {-58, -2}, {54, 184}, 256, 425), 0.4);
       }},
      {"hills", "",
       [](const std::string&) -> Result<TriangleSet> {
         return made("hills", relief_mesh(hills_height, {-50, -50}, {50, 50}, 256, 256), 0.25);
       }},
      {"bunny", "bunny",
       [](const std::string& path) -> Result<TriangleSet> { return from_file("bunny", path, 1000, 0.001, 0); }},
      {"fan piece", "",
       [](const std::string&) -> Result<TriangleSet> {
         Box3 box;
         box.add(Vec3(-45, 8, -2)), box.add(Vec3(45, 57, 31));
         return made("fan piece", contoured(fan_piece, box, 0.37), 0.05);
       }},
      {"rocker", "",
       [](const std::string&) -> Result<TriangleSet> {
         Box3 box;
         box.add(Vec3(-55, -22, -16)), box.add(Vec3(75, 40, 16));
         return made("rocker", contoured(rocker, box, 0.53), 0.1);
       }},
      {"paraboloid", "",
       [](const std::string&) -> Result<TriangleSet> {
         return unit_square(
             "paraboloid", [](double x, double y) { return 0.1 * (x * x + y * y); }, 0.2, false);
       }},
      {"saddle", "",
       [](const std::string&) -> Result<TriangleSet> {
         return unit_square(
             "saddle", [](double x, double y) { return 0.1 * x * y; }, 0.1, true);
       }},
      {"mustard", "mustard",
       [](const std::string& path) -> Result<TriangleSet> { return from_file("mustard", path, 1000, 0.002, 0); }},
  };
  return makers;
}

}  // namespace bench
