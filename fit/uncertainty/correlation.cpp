#include "fit/uncertainty/correlation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/number.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "geometry/points/kd_tree.h"

namespace partscribe::fit {
namespace {

constexpr std::size_t centres = 20000, neighbours = 200, least_points = 400;
/// Lags in pitches; the last ring is where noise is taken to have decayed.
constexpr std::array<double, 8> ring_ends = {1.2, 1.7, 2.2, 2.7, 3.5, 4.5, 5.5, 7.0};
constexpr std::size_t rings = ring_ends.size();
constexpr double significant = 3;
constexpr double of_a_filter = 0.3;  // correlation of neighbours; a mean over 2 x 2 pixels makes it 0.5
constexpr double least_part = 0.25;  // of the variance that is taken for smoothed noise
constexpr double least_fall = 0.1;   // from the first ring to the second: a mean over 9 x 9 pixels

struct RingSums {
  std::array<double, rings> product{}, pairs{}, square_lag{};
};

}  // namespace

Correlation correlation_of(const std::vector<Vec3>& places, const std::vector<double>& residuals,
                           const std::vector<int>& group, int group_count, int threads) {
  Correlation result;
  const std::size_t n = places.size();
  if (n < least_points) return result;
  std::vector<std::vector<std::uint32_t>> members(static_cast<std::size_t>(group_count));
  for (std::size_t i = 0; i < n; ++i)
    members[static_cast<std::size_t>(group[i])].push_back(static_cast<std::uint32_t>(i));
  const std::size_t stride = (n + centres - 1) / centres;

  RingSums total;
  double variance = 0, centre_count = 0, area = 0;
  for (const auto& member : members) {
    if (member.size() < neighbours) continue;
    std::vector<Vec3> own;
    for (const auto i : member) own.push_back(places[i]);
    const KdTree tree(own);
    std::vector<std::uint32_t> chosen;
    for (std::size_t k = 0; k < own.size(); k += stride) chosen.push_back(static_cast<std::uint32_t>(k));
    // The pitch of this group: four neighbours of an even grid lie one pitch away.
    std::vector<double> fourth(chosen.size());
    parallel_for(chosen.size(), threads, [&](std::size_t begin, std::size_t end) {
      std::vector<Neighbour> near;
      for (std::size_t c = begin; c < end; ++c) {
        tree.nearest(own[chosen[c]], 5, near);
        fourth[c] = std::sqrt(near.back().sq_distance);
      }
    });
    const double pitch = median_in_place(fourth);
    if (!(pitch > 0)) continue;
    constexpr std::size_t block = 256;
    std::vector<RingSums> parts((chosen.size() + block - 1) / block);
    std::vector<double> squares(parts.size(), 0);
    parallel_for(
        parts.size(), threads,
        [&](std::size_t begin, std::size_t end) {
          std::vector<Neighbour> near;
          for (std::size_t b = begin; b < end; ++b)
            for (std::size_t c = b * block; c < std::min(chosen.size(), (b + 1) * block); ++c) {
              const double centre = residuals[member[chosen[c]]];
              squares[b] += centre * centre;
              tree.nearest(own[chosen[c]], neighbours, near);
              for (const auto& m : near) {
                if (m.index == chosen[c]) continue;
                const double lag = std::sqrt(m.sq_distance) / pitch;
                const auto ring = static_cast<std::size_t>(std::lower_bound(ring_ends.begin(), ring_ends.end(), lag) -
                                                           ring_ends.begin());
                if (ring == rings) break;
                parts[b].product[ring] += centre * residuals[member[m.index]];
                parts[b].pairs[ring] += 1;
                parts[b].square_lag[ring] += lag * lag;
              }
            }
        },
        1);
    for (std::size_t b = 0; b < parts.size(); ++b) {
      variance += squares[b];
      for (std::size_t k = 0; k < rings; ++k) {
        total.product[k] += parts[b].product[k];
        total.pairs[k] += parts[b].pairs[k];
        total.square_lag[k] += parts[b].square_lag[k];
      }
    }
    centre_count += double(chosen.size());
    area += double(chosen.size()) * pitch * pitch;
  }
  if (!(variance > 0)) return result;
  variance /= centre_count;
  auto chance = [&](std::size_t k) { return std::sqrt(2 / std::max(total.pairs[k], 1.0)); };
  auto correlation = [&](std::size_t k) { return total.product[k] / std::max(total.pairs[k], 1.0) / variance; };
  double level = correlation(rings - 1);
  if (level < significant * chance(rings - 1)) level = 0;
  level = std::min(level, 0.95);
  double sum = 1;
  std::vector<double> rhos;
  for (std::size_t k = 0; k + 1 < rings; ++k) {
    const double rho = (correlation(k) - level) / (1 - level);
    if (rho < significant * chance(k) / (1 - level)) break;
    rhos.push_back(rho);
    sum += rho * total.pairs[k] / centre_count;
  }
  result.points_per_independent = sum;
  if (rhos.size() < 2) return result;
  // White noise after a Gaussian of variance s^2 has correlation A exp(-h^2 / 4 s^2). A is 1 unless something else
  // shows at lag zero alone: rough spots, points that a filter left as they were. The first two rings give A and s^2.
  const double near = total.square_lag[0] / total.pairs[0], far = total.square_lag[1] / total.pairs[1];
  const double fall = std::max(std::log(rhos[0] / rhos[1]), least_fall);
  const double part = std::clamp(rhos[0] * std::exp(near * fall / (far - near)), least_part, 1.0);
  if (rhos[0] < of_a_filter * part) return result;
  // For a mean over 3 x 3 pixels both are right within 8 %. Wide means fall off more slowly at first than a Gaussian,
  // but their sum over all lags, 4 pi s^2, holds.
  const double by_fall = (far - near) / (4 * fall), by_sum = (sum - 1) / part / (4 * pi);
  result.smoothing = std::max(by_fall, by_sum) * area / centre_count;
  return result;
}

}  // namespace partscribe::fit
