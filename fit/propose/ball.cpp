#include "fit/propose/ball.h"

#include <algorithm>
#include <cmath>

#include "core/statistics.h"
#include "geometry/least_squares.h"

namespace partscribe::fit {

Ball ball_through(const std::vector<Vec3>& points, const Vec3& origin, double unit) {
  Ball ball;
  const auto fit = [&](const std::vector<double>& weights) {
    NormalSums<4> sums;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3 q = (points[i] - origin) / unit;
      sums.add({2 * q.x(), 2 * q.y(), 2 * q.z(), 1}, q.squaredNorm(), weights[i]);
    }
    const Eigen::Vector4d x = sums.solution(1e-9);
    const double r = std::sqrt(std::max(1e-6, x[3] + x.head<3>().squaredNorm()));
    ball = {origin + unit * x.head<3>(), unit * r};
    return true;
  };
  reweighted(points.size(), {10, 2, 1e-9 * unit}, fit,
             [&](std::size_t i) { return (points[i] - ball.centre).norm() - ball.radius; });
  return ball;
}

Ball ball_of_normals(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, const Vec3& origin,
                     double unit) {
  Ball ball;
  const auto fit = [&](const std::vector<double>& weights) {
    Mat3 h = 1e-9 * Mat3::Identity();
    Vec3 b = Vec3::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!(normals[i].squaredNorm() > 0.5)) continue;
      const Mat3 across = Mat3::Identity() - normals[i] * normals[i].transpose();
      h += weights[i] * across, b += weights[i] * (across * (points[i] - origin) / unit);
    }
    ball.centre = origin + unit * solve_ldlt(h, b);
    return true;
  };
  reweighted(points.size(), {12, 2, 1e-9 * unit}, fit, [&](std::size_t i) {
    const Vec3 q = points[i] - ball.centre;
    return (q - normals[i] * normals[i].dot(q)).norm();
  });
  std::vector<double> radius;
  for (const Vec3& p : points) radius.push_back((p - ball.centre).norm());
  ball.radius = median(radius);
  return ball;
}

void polish_ball(Ball& ball, const std::vector<Vec3>& points, double reach) {
  std::vector<double> off;
  for (const Vec3& p : points) off.push_back(std::abs((p - ball.centre).norm() - ball.radius));
  double scale = std::max(reach, 2 * median(std::move(off)));
  for (int round = 0; round < 30; ++round) {
    NormalSums<4> sums;
    for (const Vec3& p : points) {
      const Vec3 q = p - ball.centre;
      const double length = q.norm(), d = length - ball.radius;
      if (!(length > 0)) continue;
      sums.add({q.x() / length, q.y() / length, q.z() / length, 1}, d, welsch_weight(d, scale));
    }
    const Eigen::Vector4d step = sums.solution(1e-9 * sums.h.trace());
    if (!step.allFinite()) return;
    ball.centre += step.head<3>();
    ball.radius += step[3];
    scale = std::max(reach, 0.7 * scale);
    if (step.norm() < 1e-10 * std::abs(ball.radius) && scale == reach) break;
  }
}

}  // namespace partscribe::fit
