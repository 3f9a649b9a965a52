#include "geometry/curvature_map.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace partscribe {
namespace {

using Grid = PaddedGrid<float>;

constexpr float like = 1.5F;  // a variance so little larger that it matters not

/// Sums over (2 reach + 1)^2 cells.
Grid sums_around(const Grid& values, int width, int height, int reach) {
  const auto stride = static_cast<std::ptrdiff_t>(width);
  std::vector<float> rows(static_cast<std::size_t>(stride * (height + 2 * reach)), 0);
  std::vector<float> line(static_cast<std::size_t>(width + 2 * reach), 0);
  for (int r = 0; r < height; ++r) {
    std::copy_n(values.row(r), width, line.data() + reach);
    float* out = rows.data() + (r + reach) * stride;
    for (int k = 0; k <= 2 * reach; ++k) {
      const float* in = line.data() + k;
      for (int c = 0; c < width; ++c) out[c] += in[c];
    }
  }
  Grid sums(width, height, 0);
  for (int r = 0; r < height; ++r) {
    float* out = sums.row(r);
    for (int k = 0; k <= 2 * reach; ++k) {
      const float* in = rows.data() + (r + k) * stride;
      for (int c = 0; c < width; ++c) out[c] += in[c];
    }
  }
  return sums;
}

}  // namespace

CurvatureMap::CurvatureMap(const RangeHeights& heights, const CurvatureGrids& windows, const Grid& sigma)
    : heights_(heights), sigma_(sigma) {
  for (const int reach : {2, 4, 8}) {
    CurvatureGrids& sums = scales_.emplace_back(heights.width, heights.height_px);
    for (const auto member : {&CurvatureGrids::xx, &CurvatureGrids::yy, &CurvatureGrids::xy, &CurvatureGrids::variance,
                              &CurvatureGrids::count})
      sums.*member = sums_around(windows.*member, heights.width, heights.height_px, reach);
  }
}

CurvatureMap::Estimate CurvatureMap::estimate(const CurvatureGrids& sums, int row, int column, const Tilt& tilt,
                                              float sigma) {
  const float n = sums.count.row(row)[column], sq = tilt.secant * tilt.secant;
  const Bend mean{sums.xx.row(row)[column] / n, sums.yy.row(row)[column] / n, sums.xy.row(row)[column] / n};
  const float steepening = std::max(sums.variance.row(row)[column] / n * sq * sq * sq / (sigma * sigma), 1.F);
  // In sums over neighbours the samples inside cancel: 9, 25, 81 and 289 windows are worth 5.5, 26, 124 and 760.
  const float root = std::sqrt(n), worth = std::max(n * root / (4.1F + 0.14F * root), 1.F);
  return {bend_of(mean, tilt), worth / steepening, steepening};
}

KnownBend CurvatureMap::at(int row, int column, const Tilt& tilt) const {
  if (!known(row, column)) return {};
  const float sigma = sigma_.row(row)[column], limit = significant_bend * sigma * sigma;
  std::array<Estimate, 3> found;
  std::size_t chosen = 0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    found[k] = estimate(scales_[k], row, column, tilt, sigma);
    if (k > 0 && found[k].steepening > like) break;
    const auto agrees = [&](const Estimate& near) {
      return near.windows * (near.bend - found[k].bend).evidence() <= limit;
    };
    if (!std::all_of(found.data(), found.data() + k, agrees)) break;
    chosen = k;
  }
  const auto& [bend, windows, steepening] = found[chosen];
  if (windows * bend.evidence() <= limit) return {};
  // Twice the variance of two coefficients, and for near windows their covariance with the plane's value.
  const float shared = chosen == 0 ? 0.0208F * std::max(1 - 1 / windows, 0.F) : 0;
  const auto unit = static_cast<float>(heights_.pixels_per_height(heights_.grid.row(row)[column]));
  return {BentSurface(bend, tilt, unit), 8 / (70 * windows) + shared, steepening > like};
}

}  // namespace partscribe
