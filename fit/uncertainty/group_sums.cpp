#include "fit/uncertainty/group_sums.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.h"

namespace partscribe::fit {

PointSums sums_of(const AllPoints& all, const Matrix& rows, const std::vector<double>& share, const Unknowns& unknowns,
                  const Welsch& kernel, double slope, int threads) {
  constexpr std::size_t block = 256;
  const std::size_t n = all.nodes.size(), blocks = (n + block - 1) / block;
  const Eigen::Index columns = rows.cols(), m = all.group_count;
  const GroupSums empty{Matrix::Zero(6 * m, 6 * m), Matrix::Zero(6 * m, columns), Vector::Zero(6 * m)};
  PointSums sums{std::vector<double>(n, 0), std::vector<double>(n, 0), empty};
  std::vector<GroupSums> parts(blocks);
  parallel_for(
      blocks, threads,
      [&](std::size_t begin, std::size_t end) {
        std::vector<double> weight(static_cast<std::size_t>(m)), pull(weight.size());
        for (std::size_t b = begin; b < end; ++b) {
          parts[b] = empty;
          for (std::size_t k = b * block; k < std::min(n, (b + 1) * block); ++k) {
            if (share[k] == 0) continue;
            std::fill(weight.begin(), weight.end(), 0), std::fill(pull.begin(), pull.end(), 0);
            for (std::size_t i = all.nodes[k].begin; i < all.nodes[k].end; ++i) {
              if (!all.used[i]) continue;
              const double unit = 1 / all.sigma[i];
              const auto g = static_cast<std::size_t>(all.group[i]);
              weight[g] += share[k] * unit * unit;
              pull[g] += share[k] * kernel.psi(all.at.value[i] * unit) * unit / slope;
            }
            const auto v =
                motion_row(all.nodes[k].place, all.jacobian.gradients[k], unknowns.center(), unknowns.size());
            const Vector j = rows.row(static_cast<Eigen::Index>(k)).transpose();
            for (Eigen::Index g = 0; g < m; ++g) {
              const double w = weight[static_cast<std::size_t>(g)], r = pull[static_cast<std::size_t>(g)];
              if (w == 0) continue;
              sums.weight[k] += w, sums.pull[k] += r;
              parts[b].motion.block<6, 6>(6 * g, 6 * g) += w * v * v.transpose();
              parts[b].coupling.middleRows<6>(6 * g) += w * v * j.transpose();
              parts[b].pull.segment<6>(6 * g) += r * v;
            }
          }
        }
      },
      1);
  for (const auto& part : parts) {
    sums.groups.motion += part.motion;
    sums.groups.coupling += part.coupling;
    sums.groups.pull += part.pull;
  }
  return sums;
}

GroupSums sums_of_imagined_views(const AllPoints& all, const Matrix& rows, const PointSums& sums,
                                 const Unknowns& unknowns) {
  constexpr Eigen::Index views = 10;
  constexpr double least_cosine = 0.25;
  GroupSums result{Matrix::Zero(6 * views, 6 * views), Matrix::Zero(6 * views, rows.cols()), Vector::Zero(6 * views)};
  std::array<Vec3, views> toward;
  for (Eigen::Index v = 0; v < views; ++v) {
    const double z = 1 - (2 * double(v) + 1) / double(views), r = std::sqrt(1 - z * z), a = 2.399963 * double(v);
    toward[static_cast<std::size_t>(v)] = {r * std::cos(a), r * std::sin(a), z};
  }
  for (std::size_t k = 0; k < all.nodes.size(); ++k) {
    if (sums.weight[k] == 0) continue;
    const Vec3& normal = all.jacobian.gradients[k];
    std::vector<Eigen::Index> seen;
    for (Eigen::Index v = 0; v < views; ++v)
      if (normal.dot(toward[static_cast<std::size_t>(v)]) > least_cosine) seen.push_back(v);
    if (seen.empty()) continue;
    const double share = 1 / double(seen.size());
    const auto motion = motion_row(all.nodes[k].place, normal, unknowns.center(), unknowns.size());
    const Vector j = rows.row(static_cast<Eigen::Index>(k)).transpose();
    const Matrix square = sums.weight[k] * share * share * motion * motion.transpose();
    const Matrix coupled = sums.weight[k] * share * motion * j.transpose();
    for (const auto a : seen) {
      for (const auto b : seen) result.motion.block<6, 6>(6 * a, 6 * b) += square;
      result.coupling.middleRows<6>(6 * a) += coupled;
      result.pull.segment<6>(6 * a) += sums.pull[k] * share * motion;
    }
  }
  return result;
}

}  // namespace partscribe::fit
