#include "geometry/images/grid_normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/ensure.h"
#include "core/parallel.h"
#include "geometry/images/padded_grid.h"
#include "geometry/images/range_heights.h"
#include "geometry/images/range_noise.h"
#include "geometry/images/window_kernels.h"

namespace partscribe::geometry {
namespace {

constexpr int strip = 24;  // rows that are worked on together, so that their planes stay in the cache
constexpr int group = 16;  // pixels that are skipped together where there are no returns

/// The planes of some rows, with two rows and columns around them.
struct Planes {
  explicit Planes(int width)
      : weight(width, strip + 4, 0),
        height(weight),
        value(weight),
        slope_x(weight),
        slope_y(weight),
        variance(weight),
        count(weight),
        sse(weight),
        bend_xx(weight),
        bend_yy(weight),
        bend_xy(weight),
        residual(weight),
        unused(static_cast<std::size_t>(width)) {}
  /// What is never written is no sample and no plane.
  void clear() { weight.fill(0), residual.fill(std::numeric_limits<float>::infinity()); }
  PaddedGrid<float> weight, height, value, slope_x, slope_y, variance, count, sse, bend_xx, bend_yy, bend_xy;
  PaddedGrid<float> residual;  ///< mean square, at least that of the noise; infinite: no plane
  std::vector<float> unused;
};

/// Columns [first, first + count) of a row.
struct Run {
  int first, count;
};

/// Runs of groups of columns that hold returns.
std::vector<Run> runs_of(const RangeHeights& h, int row) {
  std::vector<Run> runs;
  const float* z = h.grid.row(row);
  for (int c = 0; c < h.width; c += group) {
    const int size = std::min(group, h.width - c);
    int returns = 0;
    if (size == group)
      for (int k = 0; k < group; ++k) returns += z[c + k] == z[c + k];
    else
      for (int k = 0; k < size; ++k) returns += z[c + k] == z[c + k];
    if (returns == 0) continue;
    if (!runs.empty() && runs.back().first + runs.back().count == c)
      runs.back().count += size;
    else
      runs.push_back({c, size});
  }
  return runs;
}

/// Of the window that a pixel takes its normal from.
struct Choice {
  float slope_x = 0, slope_y = 0, height = 0;
  bool any = false;
};

/// The window through a pixel that is most like a plane; one farther away has to be better.
Choice best_window(const Planes& planes, int row, int column, float own_height, float tolerance) {
  Choice best, other;  // `other`: the pixel lies on none of the planes
  float best_score = std::numeric_limits<float>::infinity(), other_score = best_score;
  for (int dr = -2; dr <= 2; ++dr)
    for (int dc = -2; dc <= 2; ++dc) {
      const int r = row + dr, c = column + dc;
      const float distance = static_cast<float>(dr * dr + dc * dc);
      const float score = planes.residual.row(r)[c] * (distance > 0 ? 4 + 0.1F * distance : 1.F);
      if (!(score < std::max(best_score, other_score))) continue;
      const float slope_x = planes.slope_x.row(r)[c], slope_y = planes.slope_y.row(r)[c];
      const float here = planes.height.row(r)[c] + planes.value.row(r)[c] - slope_x * static_cast<float>(dc) -
                         slope_y * static_cast<float>(dr);
      const bool on = std::abs(here - own_height) <= tolerance;
      if (score < (on ? best_score : other_score))
        (on ? best_score : other_score) = score, (on ? best : other) = {slope_x, slope_y, here, true};
      if (on) other_score = std::min(other_score, best_score);  // no longer asked for
    }
  return best.any ? best : other;
}

/// A quadric explains what the plane leaves, and the surface turns little within the window: the plane's slope is that
/// in the middle. Only right in windows with all samples.
bool smoothly_bent(const RangeHeights& h, const Planes& planes, int row, int local, int column, const Choice& own,
                   float limit) {
  constexpr double most_turn = 0.2;  // rad from the middle to the border; sharper is an edge
  const float xx = planes.bend_xx.row(local)[column], yy = planes.bend_yy.row(local)[column],
              xy = planes.bend_xy.row(local)[column];
  const float left = planes.sse.row(local)[column] - 70 * (xx * xx + yy * yy) - 100 * xy * xy;
  if (!(left <= 19 * limit)) return false;
  const double bend = 4 * std::max({std::abs(xx), std::abs(yy), 0.5F * std::abs(xy)});
  return bend * h.pixels_per_height(own.height) <=
         most_turn * h.incidence(row, column, own.height, own.slope_x, own.slope_y);
}

}  // namespace

LargeVector<Eigen::Vector3f> grid_normals(const RangeImage& image, const GridNormalOptions& options, int threads) {
  ensure(image.width >= 0 && image.height >= 0 &&
             image.codes.size() == static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height),
         "an image has a code for every pixel");
  LargeVector<Eigen::Vector3f> normals(image.codes.size());
  if (normals.empty()) return normals;
  std::fill_n(normals.front().data(), 3 * normals.size(), 0.F);  // the constructor leaves them as they are
  const RangeHeights h(image);
  if (h.returns == 0) return normals;
  const double sigma_mm = options.sigma > 0 ? options.sigma : even_noise(h, 1000).level;
  const auto sigma =
      static_cast<float>(std::max(sigma_mm / h.mm_per_height(0), 0.3));  // a code is no finer than its rounding
  const auto tolerance = static_cast<float>(options.step_sigmas) * sigma;
  const float sq_sigma = sigma * sigma, limit = static_cast<float>(options.plane_ratio) * sq_sigma,
              bent_limit = 2 * limit;
  const double scale_x = image.q / image.pitch_x, scale_y = image.q / image.pitch_y;
  const auto fill_strip = [&](int top, int bottom, Planes& planes) {
    // Rows of the strip are counted from two above it; samples are needed four around it.
    const auto local = [&](int row) { return row - top + 2; };
    const auto at = [&](int row) { return static_cast<std::size_t>(row - top + 4); };
    std::array<std::vector<Run>, strip + 8> runs;
    for (int r = std::max(top - 4, 0); r < std::min(bottom + 4, h.height_px); ++r) {
      std::array<const float*, 5> z{};
      for (int k = -2; k <= 2; ++k) z[static_cast<std::size_t>(k + 2)] = h.grid.row(r + k);
      runs[at(r)] = runs_of(h, r);
      for (const auto& [first, count] : runs[at(r)]) {
        std::array<const float*, 5> from = z;
        for (const float*& row : from) row += first;
        samples_on_lines(from, tolerance, count, planes.weight.row(local(r)) + first,
                         planes.height.row(local(r)) + first);
      }
    }
    for (int r = std::max(top - 2, 0); r < std::min(bottom + 2, h.height_px); ++r)
      for (const auto& [first, count] : runs[at(r)]) {
        std::array<const float*, 5> z{}, w{};
        for (int k = -2; k <= 2; ++k) {
          const int row = local(r) + k;
          z[static_cast<std::size_t>(k + 2)] = planes.height.row(row) + first,
                                         w[static_cast<std::size_t>(k + 2)] = planes.weight.row(row) + first;
        }
        const int l = local(r);
        facets(z, w, count,
               {planes.value.row(l) + first, planes.slope_x.row(l) + first, planes.slope_y.row(l) + first,
                planes.variance.row(l) + first, planes.count.row(l) + first, planes.sse.row(l) + first,
                planes.unused.data(), planes.bend_xx.row(l) + first, planes.bend_yy.row(l) + first,
                planes.bend_xy.row(l) + first});
        const float *sse = planes.sse.row(l), *n = planes.count.row(l), *variance = planes.variance.row(l);
        float* const residual = planes.residual.row(l);
        for (int c = first; c < first + count; ++c)
          residual[c] = variance[c] > 0 && n[c] > 5 ? std::max(sse[c] / (n[c] - 3), sq_sigma)
                                                    : std::numeric_limits<float>::infinity();
      }
    for (int r = top; r < bottom; ++r)
      for (const auto& [first, count] : runs[at(r)]) {
        const int l = local(r);
        const float *own = h.grid.row(r), *weight = planes.weight.row(l), *value = planes.value.row(l),
                    *n = planes.count.row(l);
        const float* const residual = planes.residual.row(l);
        for (int c = first; c < first + count; ++c) {
          if (std::isnan(own[c])) continue;
          Choice choice{planes.slope_x.row(l)[c], planes.slope_y.row(l)[c], own[c] + value[c], true};
          const bool plain = weight[c] > 0 && n[c] > 12 && residual[c] <= limit;
          if (!plain && !(weight[c] > 0 && n[c] == 25 && smoothly_bent(h, planes, r, l, c, choice, bent_limit))) {
            // A return that is on no line says nothing about where the surface is.
            const float reach = weight[c] > 0 ? tolerance : std::numeric_limits<float>::max();
            choice = best_window(planes, l, c, own[c], reach);
          }
          if (!choice.any) continue;
          Eigen::Vector3f& normal =
              normals[static_cast<std::size_t>(r) * static_cast<std::size_t>(h.width) + static_cast<std::size_t>(c)];
          if (h.pinhole) {
            normal = h.normal(r, c, choice.height, choice.slope_x, choice.slope_y).cast<float>();
          } else {
            const double x = choice.slope_x * scale_x, y = choice.slope_y * scale_y,
                         unit = 1 / std::sqrt(x * x + y * y + 1);
            normal = Vec3(x * unit, y * unit, -unit).cast<float>();
          }
        }
      }
  };
  parallel_for(
      static_cast<std::size_t>(h.height_px), threads,
      [&](std::size_t begin, std::size_t end) {
        Planes planes(h.width);
        for (int top = static_cast<int>(begin); top < static_cast<int>(end); top += strip) {
          planes.clear();
          fill_strip(top, std::min(top + strip, static_cast<int>(end)), planes);
        }
      },
      4 * strip);
  return normals;
}

}  // namespace partscribe::geometry
