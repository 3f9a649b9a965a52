#include "fit/surface/picture.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "geometry/points/kd_tree.h"

namespace partscribe::fit {
namespace {

Projection parallel_along(const Vec3& away) {
  return {rotation_onto_axis(away.normalized()).transpose(), Vec3::Zero(), 0};
}

/// From a place outside of the points, if they lie within 45 degrees of their middle and well before it.
std::optional<Projection> central_from(const Vec3& origin, const std::vector<Vec3>& points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  if (!((mean - origin).norm() > 0)) return std::nullopt;
  Projection result{rotation_onto_axis((mean - origin).normalized()).transpose(), origin, (mean - origin).norm()};
  for (const Vec3& p : points) {
    const Vec3 q = result.rotation * (p - origin);
    if (!(q.z() > 0.3 * result.distance) || q.head<2>().norm() > q.z()) return std::nullopt;
  }
  return result;
}

/// The share of points that lie clearly behind or before another one at the same place of the picture.
double hidden_share(const Projection& picture, const std::vector<Vec3>& points, double spacing) {
  std::vector<Vec3> flat;
  flat.reserve(points.size());
  std::vector<double> depth;
  for (const Vec3& p : points) {
    const Vec3 q = picture(p);
    flat.emplace_back(q.x(), q.y(), 0), depth.push_back(q.z());
  }
  const KdTree tree(flat);
  std::vector<Neighbour> near;
  std::size_t hidden = 0, asked = 0;
  const std::size_t step = 1 + points.size() / 4000;
  for (std::size_t i = 0; i < points.size(); i += step, ++asked) {
    tree.nearest(flat[i], 6, near);
    for (const Neighbour& n : near)
      if (n.sq_distance < 0.25 * spacing * spacing && std::abs(depth[n.index] - depth[i]) > 3 * spacing) {
        ++hidden;
        break;
      }
  }
  return static_cast<double>(hidden) / static_cast<double>(asked);
}

/// Away from the sensor along `axis`, of unknown sense: the sensor is where the frame's origin is, if that is clearly
/// outside; else on the side to which the surface bulges.
Vec3 away_along(const Vec3& axis, const std::vector<Vec3>& points) {
  double low = 1e300, high = -1e300, sum = 0;
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) {
    const double h = axis.dot(p);
    low = std::min(low, h), high = std::max(high, h), sum += h, mean += p;
  }
  sum /= static_cast<double>(points.size()), mean /= static_cast<double>(points.size());
  const double margin = 0.5 * (high - low);
  if (low > margin) return axis;
  if (high < -margin) return -axis;
  // Covariance of the height with the squared distance from the middle: negative on a hill.
  double bulge = 0, square_sum = 0;
  std::vector<double> squares;
  for (const Vec3& p : points) {
    const Vec3 d = p - mean;
    squares.push_back((d - axis * axis.dot(d)).squaredNorm());
    square_sum += squares.back();
  }
  for (std::size_t i = 0; i < points.size(); ++i)
    bulge += (axis.dot(points[i]) - sum) * (squares[i] - square_sum / static_cast<double>(points.size()));
  if (bulge != 0) return bulge < 0 ? -axis : axis;
  Eigen::Index k = 0;
  axis.cwiseAbs().maxCoeff(&k);
  return axis[k] > 0 ? -axis : axis;
}

/// The place nearest to all rays, if they do not run parallel.
std::optional<Vec3> meeting_place(const std::vector<Vec3>& points, const std::vector<Vec3>& rays) {
  Mat3 sum = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Mat3 across = Mat3::Identity() - rays[i] * rays[i].transpose();
    sum += across, right += across * points[i];
  }
  if (std::abs(sum.determinant()) < 1e-9 * std::pow(static_cast<double>(points.size()), 3)) return std::nullopt;
  return Vec3(sum.inverse() * right);
}

}  // namespace

std::optional<Projection> find_projection(const Samples& s, const std::vector<View>& views, double spacing,
                                          double max_hidden, bool oriented) {
  std::vector<Projection> candidates;
  auto add_central = [&](const Vec3& origin) {
    if (auto central = central_from(origin, s.points)) candidates.push_back(*central);
  };
  Mat3 normal_spread = Mat3::Zero(), point_spread = Mat3::Zero();
  Vec3 normal_sum = Vec3::Zero(), ray_sum = Vec3::Zero(), mean = Vec3::Zero();
  for (const Vec3& p : s.points) mean += p / static_cast<double>(s.points.size());
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    normal_spread += s.normals[i] * s.normals[i].transpose();
    point_spread += (s.points[i] - mean) * (s.points[i] - mean).transpose();
    normal_sum += s.normals[i];
    if (!s.rays.empty()) ray_sum += s.rays[i];
  }
  if (views.size() == 1 && views[0].has_sensor) add_central(views[0].world_from_view.translation);
  const bool know_side = !s.rays.empty() || oriented;
  Vec3 away = !s.rays.empty() ? ray_sum : Vec3(-normal_sum);
  if (!s.rays.empty()) {
    if (const auto origin = meeting_place(s.points, s.rays)) add_central(*origin);
    if (ray_sum.norm() > 0.3 * static_cast<double>(s.rays.size())) candidates.push_back(parallel_along(ray_sum));
  }
  add_central(Vec3::Zero());
  const Eigen::SelfAdjointEigenSolver<Mat3> by_normals(normal_spread), by_points(point_spread);
  std::vector<Vec3> axes = {by_normals.eigenvectors().col(2), Vec3::UnitZ(), Vec3::UnitY(), Vec3::UnitX(),
                            by_points.eigenvectors().col(0)};
  for (const Vec3& axis : axes)
    candidates.push_back(
        parallel_along(know_side ? Vec3(axis.dot(away) < 0 ? -axis : axis) : away_along(axis, s.points)));
  const Projection* best = nullptr;
  double least = max_hidden;
  for (const Projection& candidate : candidates) {
    if (know_side) {
      // Back sides cannot be seen.
      std::size_t back = 0;
      for (std::size_t i = 0; i < s.points.size(); ++i) {
        const Vec3 ray = candidate.ray_to(s.points[i]);
        back += s.normals[i].dot(ray) > 0.1;
      }
      if (static_cast<double>(back) > max_hidden * static_cast<double>(s.points.size())) continue;
    }
    const double share = hidden_share(candidate, s.points, spacing);
    if (share < least) least = share, best = &candidate;
    if (share < 0.001) break;
  }
  if (!best) return std::nullopt;
  return *best;
}

}  // namespace partscribe::fit
