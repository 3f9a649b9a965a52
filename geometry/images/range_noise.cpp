#include "geometry/images/range_noise.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/statistics.h"

namespace partscribe::geometry {
namespace {

constexpr double third_difference_norm = 4.47213595499958;  // root of 1 + 9 + 9 + 1
constexpr double quantisation = 0.288675134594813;          // 1 / sqrt 12, codes: no image is less noisy
constexpr std::size_t least_samples = 60;                   // for a scale of its own

/// Standard deviation of the bulk: the median starts, and the root mean square within three deviations, corrected for
/// what that cuts off, makes it smooth where whole codes make the median jump.
double bulk_scale(std::vector<double>& sizes, double least) {
  double scale = std::max(1.4826 * median_in_place(sizes), least);
  for (int round = 0; round < 4; ++round) {
    double sum = 0;
    std::size_t count = 0;
    for (const double d : sizes)
      if (d <= 3 * scale) sum += d * d, ++count;
    if (count == 0) break;
    scale = std::max(std::sqrt(sum / static_cast<double>(count)) / 0.98660, least);
  }
  return scale;
}

/// |third difference| / norm in mm, starting at a pixel and going right or down; negative if one is missing.
double difference(const RangeHeights& heights, int r, int c, int dr, int dc) {
  float z[4];
  for (int k = 0; k < 4; ++k) {
    const int row = r + k * dr, column = c + k * dc;
    if (row >= heights.height_px || column >= heights.width) return -1;
    z[k] = heights.grid.row(row)[column];
  }
  const float d = (z[3] - z[0]) - 3 * (z[2] - z[1]);
  if (std::isnan(d)) return -1;
  return std::abs(d) / third_difference_norm * heights.mm_per_height(z[1]);
}

/// Every so manieth row and column that two differences of each of so many returns are left.
int stride_of(const RangeHeights& heights, int samples) {
  return std::max(1, static_cast<int>(std::sqrt(static_cast<double>(heights.returns) / samples)));
}

double quantisation_mm(const RangeHeights& heights) { return quantisation * heights.mm_per_height(0); }

}  // namespace

RangeNoise even_noise(const RangeHeights& heights, int samples) {
  std::vector<double> sizes;
  const int stride = stride_of(heights, samples);
  for (int r = 0; r < heights.height_px; r += stride)
    for (int c = r / stride % stride; c < heights.width; c += stride) {
      if (std::isnan(heights.grid.row(r)[c])) continue;
      for (const auto& [dr, dc] : {std::pair{0, 1}, std::pair{1, 0}})
        if (const double d = difference(heights, r, c, dr, dc); d >= 0) sizes.push_back(d);
    }
  return {bulk_scale(sizes, quantisation_mm(heights)), 0};
}

RangeNoise sloped_noise(const RangeHeights& heights, const PaddedGrid<float>& kept,
                        const PaddedGrid<float>& incidence) {
  constexpr std::array<double, 9> ends = {1.15, 1.35, 1.7, 2.2, 3, 4.5, 7, 11, 20};
  std::array<std::vector<double>, 9> sizes;
  std::array<double, 9> sums{};
  const int stride = stride_of(heights, noise_samples);
  for (int r = 0; r < heights.height_px; r += stride)
    for (int c = r / stride % stride; c < heights.width; c += stride)
      for (const auto& [dr, dc] : {std::pair{0, 1}, std::pair{1, 0}}) {
        const double d = difference(heights, r, c, dr, dc);
        if (d < 0) continue;
        float least = incidence.row(r)[c], most = least, all = 1;
        for (int k = 0; k < 4; ++k) {
          all = std::min(all, kept.row(r + k * dr)[c + k * dc]);
          least = std::min(least, incidence.row(r + k * dr)[c + k * dc]);
          most = std::max(most, incidence.row(r + k * dr)[c + k * dc]);
        }
        // One surface only: across an edge a difference is no noise.
        if (all == 0 || least == 0 || most > 1.5F * least) continue;
        const auto bin =
            static_cast<std::size_t>(std::lower_bound(ends.begin(), ends.end(), incidence.row(r)[c]) - ends.begin());
        if (bin == ends.size()) continue;
        sizes[bin].push_back(d), sums[bin] += incidence.row(r)[c];
      }
  // Least squares line through the bins' scales, weighted by their counts.
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t b = 0; b < ends.size(); ++b) {
    if (sizes[b].size() < least_samples) continue;
    const double w = static_cast<double>(sizes[b].size()), at = sums[b] / w;
    const double s = bulk_scale(sizes[b], quantisation_mm(heights));
    n += w, x += w * at, y += w * s, xx += w * at * at, xy += w * at * s;
  }
  if (n == 0) return even_noise(heights);
  const double spread = xx - x * x / n;
  const double growth = spread > 1e-6 * n ? std::max((xy - x * y / n) / spread, 0.0) : 0;
  const double level = y / n - growth * x / n;
  if (level < 0) return {0, xy / xx};
  return {level, growth};
}

}  // namespace partscribe::geometry
