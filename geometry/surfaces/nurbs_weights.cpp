#include "geometry/surfaces/nurbs_weights.h"

#include <algorithm>
#include <cmath>

#include "core/ensure.h"
#include "geometry/least_squares.h"
#include "geometry/surfaces/nurbs_edit.h"
#include "geometry/surfaces/nurbs_nearest.h"

namespace partscribe::geometry {
namespace {

constexpr int most_weight_rounds = 200;
constexpr double most_weight_log = 4.6;  // a factor of 100

/// A curve with the feet of all places on it.
struct FootedCurve {
  NurbsCurve<3> curve;
  std::vector<SplineFoot> feet;
  double sq_sum = 0;
};

FootedCurve footed(NurbsCurve<3> curve, const std::vector<Vec3>& places, const std::vector<SplineFoot>& near) {
  FootedCurve result{std::move(curve), {}};
  for (std::size_t i = 0; i < places.size(); ++i) {
    result.feet.push_back(near.empty() ? nearest_on(result.curve, places[i], 1e-6)
                                       : foot_near(result.curve, places[i], near[i].u));
    result.sq_sum += result.feet.back().distance * result.feet.back().distance;
  }
  return result;
}

/// Unknowns: three of each inner control point, then the logarithms of all weights but the first.
struct WeightUnknowns {
  Eigen::Index inner, count;
  explicit WeightUnknowns(const NurbsCurve<3>& c)
      : inner(Eigen::Index(c.points.size()) - 2), count(3 * inner + Eigen::Index(c.points.size()) - 1) {}
  Eigen::Index point(int c) const { return c >= 1 && c <= inner ? 3 * (c - 1) : -1; }
  Eigen::Index weight(int c) const { return c >= 1 ? 3 * inner + c - 1 : -1; }
};

NurbsCurve<3> stepped(NurbsCurve<3> curve, const WeightUnknowns& x, const Eigen::VectorXd& step) {
  for (int c = 1; c < int(curve.points.size()); ++c) {
    if (x.point(c) >= 0) curve.points[std::size_t(c)] += step.segment<3>(x.point(c));
    const double log_weight = std::log(curve.weights[std::size_t(c)]) + step[x.weight(c)];
    curve.weights[std::size_t(c)] = std::exp(std::clamp(log_weight, -most_weight_log, most_weight_log));
  }
  return curve;
}

/// Along a tangent a place only gets another foot: what counts is the rest (at its ends the curve stays).
void add_distances(const FootedCurve& f, const std::vector<Vec3>& places, const WeightUnknowns& x, Eigen::MatrixXd& h,
                   Eigen::VectorXd& g) {
  const int p = f.curve.t.degree;
  Eigen::MatrixXd rows(3, 4 * (p + 1));
  std::vector<Eigen::Index> columns(std::size_t(4 * (p + 1)));
  for (std::size_t i = 0; i < places.size(); ++i) {
    Vec3 at, first, second;
    f.curve.derivatives(f.feet[i].u, at, first, second);
    const double length = first.norm();
    const Vec3 along = length > 0 ? Vec3(first / length) : Vec3::Zero();
    const Mat3 across = Mat3::Identity() - along * along.transpose();
    const Vec3 off = across * (at - places[i]);
    BasisValues n;
    basis(f.curve.t, f.feet[i].u, 0, n);
    double sum = 0;
    for (int k = 0; k <= p; ++k) sum += n.value[0][k] * f.curve.weights[std::size_t(n.first + k)];
    for (int k = 0; k <= p; ++k) {
      const int c = n.first + k;
      const double share = n.value[0][k] * f.curve.weights[std::size_t(c)] / sum;
      rows.block<3, 3>(0, 4 * k) = share * across;
      rows.col(4 * k + 3) = share * (across * (f.curve.points[std::size_t(c)] - at));
      for (int d = 0; d < 3; ++d) columns[std::size_t(4 * k + d)] = x.point(c) < 0 ? -1 : x.point(c) + d;
      columns[std::size_t(4 * k + 3)] = x.weight(c);
    }
    for (std::size_t a = 0; a < columns.size(); ++a) {
      if (columns[a] < 0) continue;
      g[columns[a]] += rows.col(Eigen::Index(a)).dot(off);
      for (std::size_t b = 0; b < columns.size(); ++b)
        if (columns[b] >= 0) h(columns[a], columns[b]) += rows.col(Eigen::Index(a)).dot(rows.col(Eigen::Index(b)));
    }
  }
}

FootedCurve weights_fitted(NurbsCurve<3> start, const std::vector<Vec3>& places) {
  ensure(start.points.size() >= 3 && !places.empty(), "a curve with weights has inner control points, and points");
  if (start.weights.empty()) start.weights.assign(start.points.size(), 1.0);
  const double unit = start.weights.front();
  for (double& w : start.weights) w /= unit;
  const WeightUnknowns x(start);
  FootedCurve now = footed(std::move(start), places, {});
  Damping damping{.most = 1e12};
  for (int round = 0; round < most_weight_rounds; ++round) {
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(x.count, x.count);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(x.count);
    add_distances(now, places, x, h, g);
    const double before = now.sq_sum;
    // The ridge holds what no place sees, as a scale of all weights after the first.
    const bool moved = damped_step(
        h, g, 1e-6 * h.trace() / double(x.count), damping, 12,
        [](const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
          return Eigen::VectorXd(solve_ldlt<Eigen::Dynamic, 1>(a, b));
        },
        [&](const Eigen::VectorXd& step) {
          if (!step.allFinite()) return false;
          FootedCurve next = footed(stepped(now.curve, x, step), places, now.feet);
          if (!(next.sq_sum < now.sq_sum)) return false;
          now = std::move(next);
          return true;
        });
    if (!moved || before - now.sq_sum < 1e-9 * before) break;
  }
  return now;
}

}  // namespace

WeightFit<3> with_fitted_weights(const NurbsCurve<3>& start, const std::vector<Vec3>& places) {
  const FootedCurve fit = weights_fitted(start, places);
  WeightFit<3> result{fit.curve, std::sqrt(fit.sq_sum / double(places.size()))};
  for (const SplineFoot& foot : fit.feet) result.largest = std::max(result.largest, foot.distance);
  return result;
}

WeightFit<2> with_fitted_weights(const NurbsCurve<2>& start, const std::vector<Vec2>& places) {
  std::vector<Vec3> lifted;
  for (const Vec2& p : places) lifted.emplace_back(p.x(), p.y(), 0);
  const WeightFit<3> fit = with_fitted_weights(in_space(start), lifted);
  WeightFit<2> result{{fit.curve.t, {}, fit.curve.weights}, fit.rms, fit.largest};
  for (const Vec3& p : fit.curve.points) result.curve.points.push_back(p.head<2>());
  return result;
}

}  // namespace partscribe::geometry
