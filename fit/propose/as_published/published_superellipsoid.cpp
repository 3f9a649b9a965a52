#include "fit/propose/as_published/published_superellipsoid.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "fit/propose/superellipsoid_body.h"
#include "geometry/least_squares.h"

namespace partscribe::fit {
namespace {

constexpr std::size_t fewest_points = 20;

/// sqrt(a1 a2 a3) (F - 1) with F = N^2, and how it changes with the unknowns.
double published_residual(const SuperellipsoidBody& body, const Vec3& point, SuperellipsoidGradient* gradient) {
  double steep = 0;
  const double n = 1 + first_order_distance(body, point, gradient, &steep) * steep;
  const double factor = std::sqrt(body.a.prod()), r = factor * (n * n - 1);
  if (gradient) {
    *gradient *= 2 * factor * n * steep;
    for (int k = 6; k < 9; ++k) (*gradient)[k] += 0.5 * r;  // the factor changes with the logarithms of the sizes
  }
  return r;
}

double sum_of_squares(const SuperellipsoidBody& body, const std::vector<Vec3>& points) {
  double sum = 0;
  for (const Vec3& p : points) {
    const double r = published_residual(body, p, nullptr);
    sum += r * r;
  }
  return sum;
}

struct Descent {
  SuperellipsoidBody body;
  double sum = 0;
  int steps = 0;
  bool converged = false;
};

Descent descended(const SuperellipsoidBody& start, const std::vector<Vec3>& points,
                  const PublishedSuperellipsoidOptions& options) {
  constexpr double fallen = 1e-10;  // of the sum, below which a step is not worth taking
  constexpr int attempts = 12;
  Descent d{start, sum_of_squares(start, points), 0, false};
  Damping damping{1e-3, 0.2, 5, 1e-9, 1e9};
  while (d.steps < options.steps && !d.converged) {
    NormalSums<superellipsoid_unknowns> sums;
    for (const Vec3& p : points) {
      SuperellipsoidGradient g;
      const double r = published_residual(d.body, p, &g);
      sums.add(g, r);
    }
    for (int k = 0; k < superellipsoid_unknowns; ++k)
      if ((k >= 11 && !options.taper) || at_bound(d.body, k, -sums.g[k]))
        sums.h.row(k).setZero(), sums.h.col(k).setZero(), sums.h(k, k) = 1, sums.g[k] = 0;
    const double ridge = 1e-9 * sums.h.trace() / superellipsoid_unknowns;  // turns about an axis of symmetry
    const double before = d.sum;
    const auto solve = [&](auto h, const SuperellipsoidGradient& g) {
      h.diagonal().array() += ridge;
      return SuperellipsoidGradient(h.ldlt().solve(g));
    };
    const bool better = damped_step(sums.h, sums.g, ridge, damping, attempts, solve, [&](const auto& step) {
      const SuperellipsoidBody trial = body_after(d.body, step);
      const double sum = sum_of_squares(trial, points);
      if (!(sum < d.sum)) return false;
      d.body = trial, d.sum = sum, ++d.steps;
      return true;
    });
    d.converged = !better || before - d.sum < fallen * before;
  }
  return d;
}

/// The ellipsoid along the principal axes, as wide as the points.
SuperellipsoidBody principal_ellipsoid(const std::vector<Vec3>& points) {
  Mat3 scatter = Mat3::Zero();
  for (const Vec3& p : points) scatter += p * p.transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(scatter);
  SuperellipsoidBody body;
  body.rotation = axes.eigenvectors();
  if (body.rotation.determinant() < 0) body.rotation.col(2) *= -1;
  body.a.setZero();
  for (const Vec3& p : points) body.a = body.a.cwiseMax((body.rotation.transpose() * p).cwiseAbs());
  return body;
}

SuperellipsoidBody with_z_along(const SuperellipsoidBody& body, int axis) {
  SuperellipsoidBody turned = body;
  for (int k = 0; k < 3; ++k) {
    turned.rotation.col(k) = body.rotation.col((axis + 1 + k) % 3);
    turned.a[k] = body.a[(axis + 1 + k) % 3];
  }
  return turned;
}

}  // namespace

double equation_six(const SuperellipsoidOf<double>& s, const Pose& scan_from_shape, const std::vector<Vec3>& points) {
  SuperellipsoidBody body;
  body.rotation = scan_from_shape.rotation, body.centre = scan_from_shape.translation, body.a = {s.a1, s.a2, s.a3};
  body.e1 = s.e1, body.e2 = s.e2, body.k1 = s.taper_x, body.k2 = s.taper_y;
  return sum_of_squares(body, points);
}

Result<PublishedSuperellipsoid> published_superellipsoid(const std::vector<Vec3>& all,
                                                         const PublishedSuperellipsoidOptions& options) {
  if (all.size() < fewest_points)
    return bad_input("expected at least " + std::to_string(fewest_points) + " points of a body, found " +
                     std::to_string(all.size()));
  Vec3 origin = Vec3::Zero();
  for (const Vec3& p : all) origin += p / static_cast<double>(all.size());
  double square = 0;
  for (const Vec3& p : all) square += (p - origin).squaredNorm() / static_cast<double>(all.size());
  const double unit = std::sqrt(square);
  std::vector<Vec3> points;
  for (const Vec3& p : all) points.push_back((p - origin) / unit);
  const SuperellipsoidBody start = principal_ellipsoid(points);
  if (!(unit > 0) || !(start.a.minCoeff() > 1e-6))
    return bad_input("expected points of a body, found " + std::to_string(all.size()) + " in a plane");
  Descent best;
  for (int axis = 0; axis < 3; ++axis) {
    const Descent d = descended(with_z_along(start, axis), points, options);
    if (axis == 0 || d.sum < best.sum) best = d;
  }
  const SuperellipsoidBody& b = best.body;
  PublishedSuperellipsoid result;
  result.shape = {unit * b.a[0], unit * b.a[1], unit * b.a[2], b.e1, b.e2, b.k1, b.k2};
  result.scan_from_shape = {b.rotation, origin + unit * b.centre};
  result.objective = unit * unit * unit * best.sum;
  for (const Vec3& p : points)
    result.gof += std::abs(published_residual(b, p, nullptr)) / static_cast<double>(points.size());
  result.steps = best.steps, result.converged = best.converged;
  return result;
}

}  // namespace partscribe::fit
