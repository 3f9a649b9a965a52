#include "geometry/segment/fit_facets.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "geometry/decompose.h"
#include "geometry/segment/faces.h"

namespace partscribe::geometry {
namespace {

constexpr std::size_t most_corners = 1500;  // that a fit takes
constexpr double rough_axis = 0.2;          // how far facets of a cylinder may lean along it before it is refined

Mat3 eigenvectors(const Mat3& symmetric, Vec3* values = nullptr) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(symmetric);
  if (values) *values = solver.eigenvalues();
  return solver.eigenvectors();
}

/// The circle in the plane across `axis` through the points, by the linear fit of x^2 + y^2 = 2 a x + 2 b y + c; where
/// they are too few to tell, by their normals, which meet in the middle.
std::optional<Primitive> circle_across(const Vec3& axis, const std::vector<Vec3>& points,
                                       const std::vector<Vec3>& normals) {
  const Mat3 frame = rotation_onto_axis(axis);
  Vec3 mean = Vec3::Zero();
  for (const auto& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  double size = 0;
  for (const auto& p : points) size = std::max(size, (p - mean).norm());
  if (!(size > 0)) return std::nullopt;
  Mat3 sum = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  Eigen::Matrix2d across = Eigen::Matrix2d::Zero();
  Vec2 meeting = Vec2::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 q = frame.transpose() * (points[i] - mean) / size;
    const Vec3 row(2 * q.x(), 2 * q.y(), 1);
    sum += row * row.transpose();
    right += row * (q.x() * q.x() + q.y() * q.y());
    const Vec3 n = frame.transpose() * normals[i];
    const Vec2 t(-n.y(), n.x());
    across += t * t.transpose();
    meeting += t * t.dot(Vec2(q.x(), q.y()));
  }
  Vec2 middle;
  Vec3 spread;
  eigenvectors(sum / static_cast<double>(points.size()), &spread);
  if (spread[0] > 1e-9) {
    const Vec3 solution = solve_ldlt(sum, right);
    middle = solution.head<2>();
  } else {
    if (std::abs(across.determinant()) < 1e-9) return std::nullopt;
    middle = solve_ldlt(across, meeting);
  }
  double radius = 0;
  for (const auto& p : points) radius += ((frame.transpose() * (p - mean) / size).head<2>() - middle).norm();
  radius *= size / static_cast<double>(points.size());
  Primitive found;
  found.kind = PrimitiveKind::cylinder;
  found.axis = axis;
  found.radius = radius;
  found.point = mean + size * (frame * Vec3(middle.x(), middle.y(), 0));
  if (!found.point.allFinite() || !(radius > 0) || !std::isfinite(radius)) return std::nullopt;
  return found;
}

std::optional<Primitive> sphere_through(const std::vector<Vec3>& points) {
  if (points.size() < 6) return std::nullopt;
  Vec3 mean = Vec3::Zero();
  for (const auto& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  Mat3 sum = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  double squares = 0;
  for (const auto& p : points) squares += (p - mean).squaredNorm();
  squares /= static_cast<double>(points.size());
  for (const auto& p : points) {
    const Vec3 q = p - mean;
    sum += q * q.transpose();
    right += 0.5 * (q.squaredNorm() - squares) * q;
  }
  Vec3 spread;
  eigenvectors(sum, &spread);
  if (!(spread[0] > 1e-6 * spread[2])) return std::nullopt;
  const Vec3 offset = solve_ldlt(sum, right);
  Primitive found;
  found.kind = PrimitiveKind::sphere;
  found.point = mean + offset;
  found.radius = std::sqrt(offset.squaredNorm() + squares);
  return found;
}

}  // namespace

FacetGroup::FacetGroup(const TriangleMesh& mesh, const Facets& facets, const std::vector<std::uint32_t>& members)
    : mesh_(mesh), facets_(facets), members_(members) {
  struct Corner {
    std::uint32_t vertex, facet;
  };
  std::vector<Corner> uses;
  for (const auto f : members)
    for (const auto v : facets.facets[f].vertices) uses.push_back({v, f});
  std::sort(uses.begin(), uses.end(), [](const Corner& a, const Corner& b) {
    return a.vertex != b.vertex ? a.vertex < b.vertex : a.facet < b.facet;
  });
  std::vector<Vec3> shared, shared_normals;
  for (std::size_t i = 0; i < uses.size();) {
    const std::size_t begin = i;
    Vec3 normal = Vec3::Zero();
    for (; i < uses.size() && uses[i].vertex == uses[begin].vertex; ++i) normal += facets.facets[uses[i].facet].normal;
    const Vec3& p = mesh.vertices[uses[begin].vertex];
    normal = normal.norm() > 0.1 ? Vec3(normal.normalized()) : facets.facets[uses[begin].facet].normal;
    all_corners_.push_back(p), all_normals_.push_back(normal);
    if (i - begin > 1) shared.push_back(p), shared_normals.push_back(normal);
  }
  // Where a cut ends a facet in its middle, the corner lies on the chord, not on the surface.
  if (shared.size() >= 4)
    corners_ = std::move(shared), corner_normals_ = std::move(shared_normals);
  else
    corners_ = all_corners_, corner_normals_ = all_normals_;
  for (auto* list : {&corners_, &corner_normals_, &all_corners_, &all_normals_}) {
    const std::size_t step = list->size() / most_corners + 1;
    if (step == 1) continue;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < list->size(); i += step) (*list)[kept++] = (*list)[i];
    list->resize(kept);
  }
  for (const auto f : members)
    turning_ = std::max(
        turning_, std::acos(std::clamp(facets.facets[f].normal.dot(facets.facets[members.front()].normal), -1.0, 1.0)));
}

bool facet_fits(const Primitive& primitive, const TriangleMesh& mesh, const Facet& facet, double corner_error,
                double largest_bend) {
  // A facet that bridges the angle `bend` of a circle of radius r lies r (1 - cos(bend / 2)) inside.
  double radius = primitive.radius;
  if (primitive.kind == PrimitiveKind::torus) radius = std::max(primitive.tube, primitive.radius);
  if (primitive.kind == PrimitiveKind::cone) {
    const double along = (facet.middle - primitive.point).dot(primitive.axis);
    radius = std::abs(primitive.radius + along * std::tan(primitive.half_angle)) /
             std::max(std::cos(primitive.half_angle), 0.05);
    radius += corner_error;
  }
  const double bend = std::min(largest_bend, 1.6);
  const double twofold = primitive.kind == PrimitiveKind::cylinder || primitive.kind == PrimitiveKind::cone ? 1 : 2;
  const double sagitta = 1.05 * twofold * radius * (1 - std::cos(bend / 2)) + corner_error;
  const double direction = facet.normal.dot(surface_normal(primitive, facet.middle));
  if (std::abs(direction) < std::cos(std::min(0.75 * twofold * bend + 0.02, 1.2))) return false;
  // Between rings of a cone whose corners are turned against each other a triangle bridges twice as much.
  const bool lone = primitive.kind == PrimitiveKind::cone && facet.triangles.size() == 1;
  if (std::abs(distance(primitive, facet.middle)) > (lone ? 4 : 1) * sagitta) return false;
  const std::size_t step = facet.vertices.size() / most_corners + 1;
  for (std::size_t i = 0; i < facet.vertices.size(); i += step) {
    const double d = distance(primitive, mesh.vertices[facet.vertices[i]]);
    if (d > (primitive.kind == PrimitiveKind::torus ? sagitta : corner_error) || d < -sagitta) return false;
  }
  return true;
}

/// A circle goes through any three corners of a profile: a countersink and its hole are no torus.
bool FacetGroup::is_bent_along(const Primitive& torus) const {
  std::vector<double> angles;
  for (const auto& p : all_corners_) {
    const Vec3 d = p - torus.point;
    const double along = d.dot(torus.axis);
    angles.push_back(std::atan2(along, (d - along * torus.axis).norm() - torus.radius));
  }
  std::sort(angles.begin(), angles.end());
  std::size_t rings = angles.empty() ? 0 : 1;
  for (std::size_t i = 1; i < angles.size(); ++i) rings += angles[i] - angles[i - 1] > 0.02;
  return rings >= 4;
}

bool FacetGroup::passes(const Primitive& primitive, double corner_error, double largest_bend) const {
  if (primitive.kind == PrimitiveKind::torus && !is_bent_along(primitive)) return false;
  for (const auto& p : corners_)
    if (!(std::abs(distance(primitive, p)) <= corner_error)) return false;
  int side = 0;
  for (const auto f : members_) {
    const Facet& facet = facets_.facets[f];
    if (!facet_fits(primitive, mesh_, facet, corner_error, largest_bend)) return false;
    const int s = facet.normal.dot(surface_normal(primitive, facet.middle)) > 0 ? 1 : -1;
    if (side != 0 && s != side) return false;
    side = s;
  }
  return true;
}

std::optional<Primitive> FacetGroup::guess(PrimitiveKind kind, const std::vector<Vec3>& corners,
                                           const std::vector<Vec3>& normals) const {
  if (kind == PrimitiveKind::sphere) return sphere_through(corners);
  if (kind == PrimitiveKind::torus) {
    if (members_.size() < 8 || corners.size() < 10) return std::nullopt;
    PrimitiveFitOptions options;
    const auto fit = fit_primitive(PrimitiveKind::torus, corners, normals, options);
    if (!fit || !(fit->primitive.tube > 0)) return std::nullopt;
    return fit->primitive;
  }
  double total = 0;
  Vec3 mean = Vec3::Zero();
  for (const auto f : members_)
    total += facets_.facets[f].area, mean += facets_.facets[f].area * facets_.facets[f].normal;
  if (!(total > 0)) return std::nullopt;
  mean /= total;
  Mat3 moments = Mat3::Zero();
  for (const auto f : members_) {
    const Facet& facet = facets_.facets[f];
    const Vec3 n = kind == PrimitiveKind::cone ? Vec3(facet.normal - mean) : facet.normal;
    moments += facet.area / total * n * n.transpose();
  }
  Vec3 spread;
  Vec3 axis = eigenvectors(moments, &spread).col(0);
  if (!(spread[1] > 1e-6)) return std::nullopt;  // all look the same way
  if (kind == PrimitiveKind::cylinder) {
    for (const auto f : members_)
      if (std::abs(facets_.facets[f].normal.dot(axis)) > rough_axis) return std::nullopt;
    return circle_across(axis, corners, normals);
  }
  // All planes that touch a cone meet in its apex.
  Mat3 sum = Mat3::Zero();
  Vec3 right = Vec3::Zero(), middle = Vec3::Zero();
  for (const auto& p : corners) middle += p;
  middle /= static_cast<double>(corners.size());
  for (const auto f : members_) {
    const Facet& facet = facets_.facets[f];
    sum += facet.area * facet.normal * facet.normal.transpose();
    right += facet.area * facet.normal * facet.normal.dot(facet.middle - middle);
  }
  Vec3 values;
  eigenvectors(sum / total, &values);
  if (!(values[0] > 1e-6)) return std::nullopt;
  const Vec3 apex = middle + solve_ldlt(sum, right);
  double along = 0, radius = 0, weight = 0;
  for (const auto& p : corners) along += (p - apex).dot(axis);
  if (along < 0) axis = -axis, along = -along;
  double squares = 0, products = 0;
  for (const auto& p : corners) {
    const double t = (p - apex).dot(axis);
    squares += t * t, products += t * (p - apex - t * axis).norm();
    weight += 1;
  }
  if (!(squares > 0) || !apex.allFinite()) return std::nullopt;
  const double slope = products / squares;
  along /= weight, radius = along * slope;
  Primitive found;
  found.kind = PrimitiveKind::cone;
  found.axis = axis, found.point = apex + along * axis, found.radius = radius, found.half_angle = std::atan(slope);
  if (found.half_angle < radians(1) || found.half_angle > radians(89)) return std::nullopt;
  return found;
}

std::optional<Primitive> FacetGroup::fit(PrimitiveKind kind, double corner_error, double largest_bend) const {
  if (members_.size() < 3) return std::nullopt;
  auto found = guess(kind, corners_, corner_normals_);
  if (found && passes(*found, corner_error, largest_bend)) return found;
  // A strip of three facets shows too little of the circle by its inner corners alone.
  if (kind == PrimitiveKind::cylinder && members_.size() < 6) {
    auto wider = guess(kind, all_corners_, all_normals_);
    if (wider && passes(*wider, corner_error, largest_bend)) return wider;
  }
  if (!found || kind == PrimitiveKind::sphere || kind == PrimitiveKind::torus || corners_.size() < 8)
    return std::nullopt;
  double off = 0;
  for (const auto& p : corners_) off = std::max(off, std::abs(distance(*found, p)));
  if (off > 0.1 * found->radius) return std::nullopt;
  PrimitiveFitOptions options;
  options.start = *found;
  const auto refined = fit_primitive(kind, corners_, corner_normals_, options);
  if (refined && passes(refined->primitive, corner_error, largest_bend)) return refined->primitive;
  return std::nullopt;
}

}  // namespace partscribe::geometry
