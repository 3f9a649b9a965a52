#include "geometry/images/curvature_map.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace partscribe::geometry {
namespace {

using Grid = PaddedGrid<float>;

constexpr float like = 1.5F;  // a variance so little larger that it matters not

using Line = Eigen::ArrayXf;

/// A line and its sums over 2, 4, 8 and 16 neighbours, each from the one before.
struct DoubledSums {
  explicit DoubledSums(Line values) {
    sums[0] = std::move(values);
    for (std::size_t k = 1; k < sums.size(); ++k) {
      const Eigen::Index width = Eigen::Index{1} << (k - 1), size = sums[k - 1].size() - width;
      sums[k] = sums[k - 1].head(size) + sums[k - 1].tail(size);
    }
  }
  std::array<Line, 5> sums;
};

constexpr std::array<int, 3> reaches = {2, 4, 8};  // windows are one wider than a power of two

/// Sums over (2 reach + 1)^2 cells for each reach.
std::array<Grid, reaches.size()> window_sums(const Grid& values, int width, int height) {
  constexpr int widest = reaches.back();
  std::array<std::vector<Line>, reaches.size()> rows;  // sums along rows, with empty rows above and below
  for (std::size_t k = 0; k < reaches.size(); ++k)
    rows[k].assign(static_cast<std::size_t>(height + 2 * reaches[k]), Line::Zero(width));
  for (int r = 0; r < height; ++r) {
    Line line = Line::Zero(width + 2 * widest);
    line.segment(widest, width) = Eigen::Map<const Line>(values.row(r), width);
    const DoubledSums doubled(std::move(line));
    for (std::size_t k = 0; k < reaches.size(); ++k)
      rows[k][static_cast<std::size_t>(r + reaches[k])] =
          doubled.sums[k + 2].segment(widest - reaches[k], width) + doubled.sums[0].segment(widest + reaches[k], width);
  }
  std::array<Grid, reaches.size()> result = {Grid(width, height, 0), Grid(width, height, 0), Grid(width, height, 0)};
  for (std::size_t k = 0; k < reaches.size(); ++k) {
    std::vector<Line> sums = rows[k];
    for (std::size_t doubled = 1; doubled <= static_cast<std::size_t>(reaches[k]); doubled *= 2)
      for (std::size_t r = 0; r + doubled < sums.size(); ++r) sums[r] += sums[r + doubled];
    for (int r = 0; r < height; ++r)
      Eigen::Map<Line>(result[k].row(r), width) =
          sums[static_cast<std::size_t>(r)] + rows[k][static_cast<std::size_t>(r + 2 * reaches[k])];
  }
  return result;
}

}  // namespace

CurvatureMap::CurvatureMap(const RangeHeights& heights, const CurvatureGrids& windows, const Grid& sigma)
    : heights_(heights), sigma_(sigma) {
  scales_.assign(reaches.size(), CurvatureGrids(heights.width, heights.height_px));
  for (const auto member : {&CurvatureGrids::xx, &CurvatureGrids::yy, &CurvatureGrids::xy, &CurvatureGrids::variance,
                            &CurvatureGrids::count}) {
    auto sums = window_sums(windows.*member, heights.width, heights.height_px);
    for (std::size_t k = 0; k < sums.size(); ++k) scales_[k].*member = std::move(sums[k]);
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
  std::array<Estimate, reaches.size()> found;
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
  if (windows * bend.evidence() <= limit) return {{}, 0, 8 / (70 * windows), false};
  // Twice the variance of two coefficients, and for near windows their covariance with the plane's value.
  const float shared = chosen == 0 ? 0.0208F * std::max(1 - 1 / windows, 0.F) : 0;
  // What bends in one place only may be a crease: through the middle of a window it lies .8 of an arc's coefficient
  // beside the arc, and chi^2 tells the two apart by 6.5 times its square.
  const float square = bend.evidence() / (70 * sigma * sigma),
              crease = chosen == 0 ? 0.64F * square / (1 + std::exp(0.5F * 6.5F * square)) : 0;
  const auto unit = static_cast<float>(heights_.pixels_per_height(heights_.grid.row(row)[column]));
  return {BentSurface(bend, tilt, unit), 8 / (70 * windows) + shared, crease, steepening > like};
}

}  // namespace partscribe::geometry
