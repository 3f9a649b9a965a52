/// Least squares by normal equations: robust by iterated weights, and damped where the equations are far from linear.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/statistics.h"
#include "geometry/decompose.h"

namespace partscribe::geometry {

/// Sum of weight (row . x - value)^2 over samples, a quadratic function of n unknowns x.
template <int n>
struct NormalSums {
  using Row = Eigen::Matrix<double, n, 1>;
  Eigen::Matrix<double, n, n> h = Eigen::Matrix<double, n, n>::Zero();  ///< sum of weight row row'
  Row g = Row::Zero();                                                  ///< sum of weight value row

  void add(const Row& row, double value, double weight = 1) {
    h += weight * row * row.transpose();
    g += weight * value * row;
  }
  /// The x that makes it least. `ridge` on the diagonal holds what the samples leave open near zero.
  Row solution(double ridge) const {
    Eigen::Matrix<double, n, n> a = h;
    a.diagonal().array() += ridge;
    return solve_ldlt(a, g);
  }
};

/// Weight of a sample that is `off`, in units of `scale` (Welsch; Holland and Welsch 1977).
inline double welsch_weight(double off, double scale) { return std::exp(-0.5 * (off / scale) * (off / scale)); }

/// How the scale of the weights follows the samples from round to round.
struct Reweighting {
  int rounds = 12;
  double times = 2;  ///< of the median of what the samples are off
  double least = 0;  ///< of the scale, in the samples' unit
  double fall = 1;   ///< below 1: the scale falls to this share of itself each round, though not below `least`
};

/// Iterated weights: fits all samples, weighs each by how far the fit leaves it off, and fits again. Starts and ends
/// with a fit, of weights of one at first.
///   bool fit(const std::vector<double>& weights)   false: no fit was possible, and the rounds end
///   double off(std::size_t i)                      of sample i from the last fit
template <class Fit, class Off>
bool reweighted(std::size_t count, const Reweighting& how, Fit fit, Off off) {
  std::vector<double> weights(count, 1), offs(count);
  double scale = 0;
  for (int round = 0; round < how.rounds; ++round) {
    if (!fit(weights)) return false;
    for (std::size_t i = 0; i < count; ++i) offs[i] = std::abs(off(i));
    const double wide = std::max(how.least, how.times * median(offs));
    scale = round == 0 || how.fall == 1 ? wide : std::min(wide, std::max(how.least, how.fall * scale));
    for (std::size_t i = 0; i < count; ++i) weights[i] = welsch_weight(offs[i], scale);
  }
  return true;
}

/// How much a step of Levenberg and Marquardt is damped, and how that changes.
struct Damping {
  double value = 1e-3;
  double less = 0.1, more = 10;       ///< after a step that was taken, after one that was refused
  double least = 1e-9, most = 1e300;  ///< of the value
};

/// One step from normal equations h and g (of the residuals: the step is downhill, along -g): damped by more and more,
/// each unknown in its own units, until `take(step)` takes it. `ridge` is added to the diagonal before it is damped.
template <class Matrix, class Vector, class Solve, class Take>
bool damped_step(const Matrix& h, const Vector& g, double ridge, Damping& damping, int attempts, Solve solve,
                 Take take) {
  for (int attempt = 0; attempt < attempts; ++attempt) {
    Matrix damped = h;
    for (Eigen::Index k = 0; k < damped.rows(); ++k) damped(k, k) += damping.value * (h(k, k) + ridge);
    if (take(Vector(-solve(damped, g)))) {
      damping.value = std::max(damping.value * damping.less, damping.least);
      return true;
    }
    damping.value = std::min(damping.value * damping.more, damping.most);
  }
  return false;
}

}  // namespace partscribe::geometry
