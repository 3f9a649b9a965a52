/// What the recoveries of superellipsoids and supertoroids share: the gauge of a superellipse, and a Gaussian-uniform
/// mixture of points on a surface and points anywhere.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/number.h"
#include "geometry/least_squares.h"
#include "geometry/vec.h"

namespace partscribe::fit {

/// (x^p + y^p)^(1/p) of x, y >= 0 and its derivatives by x, y and p.
struct SuperellipseGauge {
  double value, gx, gy, gp;
};

inline SuperellipseGauge superellipse_gauge(double x, double y, double p) {
  const double big = std::max({x, y, 1e-12}), small = std::min(x, y);
  SuperellipseGauge g;
  g.value = big * std::pow(1 + std::pow(small / big, p), 1 / p);
  const double ux = std::max(x / g.value, 1e-12), uy = std::max(y / g.value, 1e-12);
  g.gx = std::pow(ux, p - 1), g.gy = std::pow(uy, p - 1);
  g.gp = g.value / p * (g.gx * ux * std::log(ux) + g.gy * uy * std::log(uy));
  return g;
}

/// The mixture's own numbers, on data of unit size.
struct MixtureState {
  double sigma = 0.3;     ///< of inliers
  double outliers = 0.1;  ///< share of the uniform part
  double cost = 0;        ///< nats per point, less is better
  double inliers = 0;     ///< mean membership
};

/// Expectation maximisation (EM) on the first `count` points, of a Gaussian about the surface and a uniform density in
/// `volume`. sigma falls by no more than a third per round, so that early rounds see all points, and to no less than
/// `floor`. `State` is a MixtureState with `unknowns` unknowns for which these are defined:
///   double residual(const State&, const Vec3&, Gradient*)   signed distance to first order, and its derivatives
///   State stepped(const State&, const Gradient&)            after a step
///   double rough_area(const State&)                         over which the inliers are spread
///   bool held(const State&, int k, double push)             unknown k is at a bound, and `push` points beyond it
template <int unknowns, class State>
void improve_mixture(State& s, const std::vector<Vec3>& points, std::size_t count, double volume, double floor,
                     int rounds) {
  using Gradient = Eigen::Matrix<double, unknowns, 1>;
  const auto n = static_cast<double>(count);
  std::vector<double> d(count), weight(count);
  Damping damping{1e-3, 0.2, 6, 1e-8, 1e6};
  for (std::size_t i = 0; i < count; ++i) d[i] = residual(s, points[i], nullptr);
  double last_cost = 1e300;
  for (int round = 0; round < rounds; ++round) {
    const double gauss = (1 - s.outliers) / (std::sqrt(2 * pi) * s.sigma * rough_area(s));
    const double flat = s.outliers / volume;
    double sum_w = 0, sum_wd2 = 0;
    s.cost = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double g = gauss * std::exp(-0.5 * d[i] * d[i] / (s.sigma * s.sigma));
      weight[i] = g / (g + flat);
      sum_w += weight[i], sum_wd2 += weight[i] * d[i] * d[i];
      s.cost -= std::log(g + flat);
    }
    s.cost /= n;
    s.inliers = sum_w / n;
    if (round == rounds - 1) break;

    NormalSums<unknowns> sums;
    for (std::size_t i = 0; i < count; ++i) {
      if (weight[i] < 1e-4) continue;
      Gradient g;
      residual(s, points[i], &g);
      sums.h.template selfadjointView<Eigen::Lower>().rankUpdate(g, weight[i]);
      sums.g += weight[i] * d[i] * g;
    }
    sums.h = sums.h.template selfadjointView<Eigen::Lower>();
    for (int k = 0; k < unknowns; ++k)
      if (held(s, k, -sums.g[k])) sums.h.row(k).setZero(), sums.h.col(k).setZero(), sums.h(k, k) = 1, sums.g[k] = 0;
    double gain = 0;
    const auto solve = [&](auto h, const Gradient& g) {
      h.diagonal().array() += 1e-6 * sum_w + 1e-12;
      return Gradient(h.ldlt().solve(g));
    };
    const bool better = damped_step(sums.h, sums.g, 0, damping, 6, solve, [&](const Gradient& step) {
      const State trial = stepped(s, step);
      std::vector<double> trial_d(count);
      double sum = 0;
      for (std::size_t i = 0; i < count; ++i) {
        trial_d[i] = residual(trial, points[i], nullptr);
        sum += weight[i] * trial_d[i] * trial_d[i];
      }
      if (!(sum < sum_wd2)) return false;
      gain = (sum_wd2 - sum) / sum_wd2;
      s = trial, d.swap(trial_d), sum_wd2 = sum;
      return true;
    });
    const double sigma = std::max(std::sqrt(sum_wd2 / std::max(sum_w, 1e-9)), floor);
    const bool settled = std::abs(sigma - s.sigma) < 1e-3 * s.sigma;
    s.sigma = std::max(sigma, 0.67 * s.sigma);
    s.outliers = std::clamp(1 - sum_w / n, 0.005, 0.7);
    if ((!better || gain < 1e-5) && settled && std::abs(s.cost - last_cost) < 1e-6) round = std::max(round, rounds - 2);
    last_cost = s.cost;
  }
}

/// A sigma to start from: of two thirds of the points.
template <class State>
double start_sigma(const State& s, const std::vector<Vec3>& points, std::size_t count) {
  std::vector<double> d(count);
  for (std::size_t i = 0; i < count; ++i) d[i] = std::abs(residual(s, points[i], nullptr));
  std::sort(d.begin(), d.end());
  return std::max(1e-3, 1.5 * d[count * 2 / 3]);
}

}  // namespace partscribe::fit
