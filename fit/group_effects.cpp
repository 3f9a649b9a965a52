#include "fit/group_effects.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

namespace partscribe {
namespace {

/// Student's quantile over the Gaussian's for 95 % intervals (Abramowitz & Stegun 26.7.5).
double student_factor(double freedom) {
  const double z = 1.959964, z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z, f = std::max(freedom, 3.0);
  return 1 + ((z3 + z) / (4 * f) + (5 * z5 + 16 * z3 + 3 * z) / (96 * f * f) +
              (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * f * f * f)) / z;
}

/// Data z ~ N(0, noise 1 + v0 s[0] + v1 s[1]).
struct Components {
  std::array<Matrix, 2> s;
  Vector z;
  double noise;

  Matrix covariance(const std::array<double, 2>& v) const {
    return noise * Matrix::Identity(z.size(), z.size()) + v[0] * s[0] + v[1] * s[1];
  }
  double minus_log_likelihood(const std::array<double, 2>& v) const {
    const Eigen::LLT<Matrix> factor(covariance(v));
    if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
    double log_determinant = 0;
    for (Eigen::Index k = 0; k < z.size(); ++k) log_determinant += 2 * std::log(factor.matrixLLT()(k, k));
    return 0.5 * (log_determinant + z.dot(factor.solve(z)));
  }
};

/// One variance at a time, first over all orders of magnitude, then finer and finer.
std::array<double, 2> most_likely(const Components& data, const std::array<double, 2>& unit) {
  constexpr int rounds = 6, places = 18;
  std::array<double, 2> best = {0, 0};
  double least = data.minus_log_likelihood(best);
  for (int round = 0; round < rounds; ++round) {
    for (int c = 0; c < 2; ++c) {
      const double centre = round == 0 || best[c] <= 0 ? 0 : std::log10(best[c] / unit[c]) - 2;
      const double width = round == 0 || best[c] <= 0 ? 8 : 4 * std::pow(0.25, round);
      std::array<double, 2> trial = best;
      for (int k = 0; k <= places; ++k) {
        trial[c] = k == 0 ? 0 : unit[c] * std::pow(10, 2 + centre + width * ((k - 1.0) / (places - 1) - 0.5));
        const double value = data.minus_log_likelihood(trial);
        if (value < least) least = value, best = trial;
      }
    }
  }
  return best;
}

}  // namespace

GroupEffects group_effects(const std::vector<GroupSums>& groups, const Matrix& h_inverse, double noise) {
  GroupEffects result;
  const Eigen::Index unknowns = h_inverse.rows(), m = static_cast<Eigen::Index>(groups.size());
  result.covariance = Matrix::Zero(unknowns, unknowns);
  if (m < 2) return result;
  Matrix coupling(6 * m, unknowns), a = Matrix::Zero(6 * m, 6 * m);
  Vector pull(6 * m);
  for (Eigen::Index k = 0; k < m; ++k) {
    const auto& g = groups[static_cast<std::size_t>(k)];
    coupling.middleRows(6 * k, 6) = g.coupling;
    a.block(6 * k, 6 * k, 6, 6) = g.motion;
    pull.segment(6 * k, 6) = g.pull;
  }
  // What the fit has absorbed of the motions is no evidence.
  a -= coupling * h_inverse * coupling.transpose();
  a = (0.5 * (a + a.transpose())).eval();
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(a);
  const double cut = 1e-6 * std::max(a.trace() / double(6 * m), 1e-300);
  Eigen::Index first = 0;
  while (first < 6 * m && eigen.eigenvalues()[first] <= cut) ++first;
  const Eigen::Index rank = 6 * m - first;
  if (rank < 2) return result;
  const Vector root = eigen.eigenvalues().tail(rank).cwiseSqrt();
  const Matrix u = eigen.eigenvectors().rightCols(rank);
  Components data;
  data.noise = noise;
  data.z = root.cwiseInverse().asDiagonal() * (u.transpose() * pull);
  const Matrix half = root.asDiagonal() * u.transpose();
  std::array<double, 2> unit;
  for (int c = 0; c < 2; ++c) {
    Matrix columns(rank, 3 * m);
    for (Eigen::Index k = 0; k < m; ++k) columns.middleCols(3 * k, 3) = half.middleCols(6 * k + 3 * c, 3);
    data.s[static_cast<std::size_t>(c)] = columns * columns.transpose();
    unit[static_cast<std::size_t>(c)] = noise * double(rank) / std::max(columns.squaredNorm(), 1e-300);
  }
  const auto variance = most_likely(data, unit);
  result.shift = std::sqrt(variance[0]), result.turn = std::sqrt(variance[1]);
  const Matrix precision = data.covariance(variance).llt().solve(Matrix::Identity(rank, rank));
  for (int c = 0; c < 2; ++c) {
    const auto at = static_cast<std::size_t>(c);
    if (variance[at] <= 0) continue;
    const Matrix share = variance[at] * precision * data.s[at];
    const double freedom = share.cwiseProduct(share.transpose()).sum();  // of a chi square as uncertain as the variance
    const double factor = student_factor(freedom);
    for (const auto& g : groups) {
      const Matrix effect = h_inverse * g.coupling.middleRows(3 * c, 3).transpose();
      result.covariance += factor * factor * variance[at] * effect * effect.transpose();
    }
  }
  return result;
}

}  // namespace partscribe
