#include "bench/recovery/best_fit.h"

#include <Eigen/Cholesky>

#include "model/distance/distance.h"

namespace partscribe::testing::recovery {
namespace {

/// Parameters of the truth, then rotation vector times size and shift of the part in the scan.
struct State {
  Values values;
  Pose scan_from_part;
};

State moved(const Case& c, const State& state, const Eigen::VectorXd& step) {
  State result = state;
  const auto n = static_cast<Eigen::Index>(c.truth.parameters.size());
  for (Eigen::Index k = 0; k < n; ++k) result.values[c.truth.parameters[static_cast<std::size_t>(k)].name] += step[k];
  const Pose change{rotation_of(step.segment<3>(n) / c.size), step.segment<3>(n + 3)};
  result.scan_from_part = state.scan_from_part * change;
  return result;
}

/// In sigmas, of every true point: orthogonal distances. (Those along the rays are worse beside the limb, where noise
/// throws rays past the part.)
Eigen::VectorXd residuals(const Case& c, const State& state) {
  const ModelDistance distance(c.truth, state.values);
  const Pose part_from_scan = state.scan_from_part.inverse();
  Eigen::VectorXd e(static_cast<Eigen::Index>(c.measured.size()));
  for (std::size_t i = 0; i < c.measured.size(); ++i)
    e[static_cast<Eigen::Index>(i)] = distance(part_from_scan * c.measured[i]).distance / c.sigma[i];
  return e;
}

}  // namespace

std::vector<double> best_numbers(const Case& c) {
  if (c.measured.empty()) return {};
  State state{values_of(c.truth), c.scan_from_part};
  const auto n = static_cast<Eigen::Index>(c.truth.parameters.size()) + 6;
  const double h = 1e-5 * c.size;
  Eigen::VectorXd e = residuals(c, state);
  for (int round = 0; round < 8; ++round) {
    Eigen::MatrixXd j(e.size(), n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const Eigen::VectorXd step = h * Eigen::VectorXd::Unit(n, k);
      j.col(k) = (residuals(c, moved(c, state, step)) - residuals(c, moved(c, state, -step))) / (2 * h);
    }
    // The wide prior of the bound: what is free stays.
    const Eigen::MatrixXd normal = j.transpose() * j + Eigen::MatrixXd::Identity(n, n) / (c.size * c.size);
    const Eigen::VectorXd step = -normal.ldlt().solve(j.transpose() * e);
    const State next = moved(c, state, step);
    const Eigen::VectorXd after = residuals(c, next);
    if (!(after.squaredNorm() < e.squaredNorm())) break;
    state = next, e = after;
  }
  std::vector<double> numbers;
  for (const auto& p : c.truth.parameters) numbers.push_back(state.values[p.name]);
  return numbers;
}

}  // namespace partscribe::testing::recovery
