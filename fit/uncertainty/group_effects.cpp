#include "fit/uncertainty/group_effects.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "geometry/decompose.h"

namespace partscribe::fit {
namespace {

/// Student's quantile divided by the Gaussian's for 95 % intervals (Abramowitz & Stegun 26.7.5).
double student_factor(double freedom) {
  const double z = 1.959964, z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z, f = std::max(freedom, 3.0);
  return 1 + ((z3 + z) / (4 * f) + (5 * z5 + 16 * z3 + 3 * z) / (96 * f * f) +
              (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * f * f * f)) /
                 z;
}

/// Data z ~ N(0, noise 1 + sum v[c] s[c]).
struct Components {
  std::vector<Matrix> s;
  Vector z;
  double noise;

  Matrix covariance(const std::vector<double>& v) const {
    Matrix sum = noise * Matrix::Identity(z.size(), z.size());
    for (std::size_t c = 0; c < s.size(); ++c) sum += v[c] * s[c];
    return sum;
  }
  double minus_log_likelihood(const std::vector<double>& v) const {
    const Eigen::LLT<Matrix> factor(covariance(v));
    if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
    double log_determinant = 0;
    for (Eigen::Index k = 0; k < z.size(); ++k) log_determinant += 2 * std::log(factor.matrixLLT()(k, k));
    return 0.5 * (log_determinant + z.dot(factor.solve(z)));
  }
};

/// One variance at a time, first over all orders of magnitude, then finer and finer. `unit`: what could just be seen.
std::vector<double> most_likely(const Components& data, const std::vector<double>& unit) {
  constexpr int rounds = 6, places = 18;
  std::vector<double> best(unit.size(), 0);
  double least = data.minus_log_likelihood(best);
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t c = 0; c < unit.size(); ++c) {
      const double centre = round == 0 || best[c] <= 0 ? 0 : std::log10(best[c] / unit[c]) - 2;
      const double width = round == 0 || best[c] <= 0 ? 8 : 4 * std::pow(0.25, round);
      std::vector<double> trial = best;
      for (int k = 0; k <= places; ++k) {
        trial[c] = k == 0 ? 0 : unit[c] * std::pow(10, 2 + centre + width * ((k - 1.0) / (places - 1) - 0.5));
        const double value = data.minus_log_likelihood(trial);
        if (value < least) least = value, best = trial;
      }
    }
  }
  return best;
}

/// The mean of the one variance by its likelihood, every standard deviation being as good as another beforehand: where
/// few numbers tell, the most likely one is often 0.
double expected(const Components& data, double unit) {
  constexpr int decades = 10, places = 12;  // a decade
  std::vector<double> variance, minus_log;
  for (int k = 0; k <= decades * places; ++k) {
    variance.push_back(unit * std::pow(10, double(k) / places - 3));
    minus_log.push_back(data.minus_log_likelihood({variance.back()}));
  }
  const double least = *std::min_element(minus_log.begin(), minus_log.end());
  double sum = 0, weights = 0;
  for (std::size_t k = 0; k < variance.size(); ++k) {
    const double weight = std::sqrt(variance[k]) * std::exp(least - minus_log[k]);
    sum += weight * variance[k], weights += weight;
  }
  return sum / weights;
}

/// The columns `from` to `to` of every group's six.
Matrix motions_of(const Matrix& columns, Eigen::Index from, Eigen::Index to) {
  const Eigen::Index m = columns.cols() / 6, width = to - from;
  Matrix chosen(columns.rows(), width * m);
  for (Eigen::Index k = 0; k < m; ++k) chosen.middleCols(width * k, width) = columns.middleCols(6 * k + from, width);
  return chosen;
}

}  // namespace

GroupEffects group_effects(const GroupSums& groups, const Matrix& h_inverse, double noise, Motions motions) {
  GroupEffects result;
  const Eigen::Index size = groups.pull.size();
  if (size < 12) return result;
  // What the fit has absorbed of the motions is no evidence.
  Matrix a = groups.motion - groups.coupling * h_inverse * groups.coupling.transpose();
  a = (0.5 * (a + a.transpose())).eval();
  const auto eigen = eigensystem(a);
  const double cut = 1e-6 * std::max(a.trace() / double(size), 1e-300);
  Eigen::Index first = 0;
  while (first < size && eigen.values[first] <= cut) ++first;
  const Eigen::Index rank = size - first;
  if (rank < 2) return result;
  const Vector root = eigen.values.tail(rank).cwiseSqrt();
  const Matrix u = eigen.vectors.rightCols(rank);
  Components data;
  data.noise = noise;
  data.z = root.cwiseInverse().asDiagonal() * (u.transpose() * groups.pull);
  const Matrix half = root.asDiagonal() * u.transpose();
  std::vector<double> unit;
  auto add = [&](Eigen::Index from, Eigen::Index to) {
    const Matrix columns = motions_of(half, from, to);
    data.s.push_back(columns * columns.transpose());
    unit.push_back(noise * double(rank) / std::max(columns.squaredNorm(), 1e-300));
  };
  if (motions == Motions::tied) {
    add(0, 6);
  } else {
    add(0, 3), add(3, 6);
  }
  const auto variance = most_likely(data, unit);
  const Matrix precision = data.covariance(variance).llt().solve(Matrix::Identity(rank, rank));
  auto widened = [&](std::size_t c) {
    const Matrix share = variance[c] * precision * data.s[c];
    const double freedom = share.cwiseProduct(share.transpose()).sum();  // of a chi square as uncertain as the variance
    return std::sqrt(variance[c]) * student_factor(freedom);
  };
  result.shift = widened(0), result.turn = widened(variance.size() - 1);
  if (motions == Motions::tied) result.shift = result.turn = std::max(result.shift, std::sqrt(expected(data, unit[0])));
  return result;
}

Matrix covariance_of(const GroupEffects& effects, const GroupSums& groups, const Matrix& h_inverse) {
  const Matrix answers = h_inverse * groups.coupling.transpose();
  const Matrix shifts = effects.shift * motions_of(answers, 0, 3);
  const Matrix turns = effects.turn * motions_of(answers, 3, 6);
  return shifts * shifts.transpose() + turns * turns.transpose();
}

}  // namespace partscribe::fit
