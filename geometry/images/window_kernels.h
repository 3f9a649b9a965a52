/// The inner loops over small windows of range images, many windows at a time.
///
/// Heights are plain numbers of any unit, noise is in the same unit; x runs along a row, y down the rows, both in
/// pixels from the middle of the window. Missing samples are NaN in lines and have weight 0 in planes.
#pragma once

#include <array>

#include "core/layers.h"

namespace partscribe::geometry {

/// Where the results of `trimmed_lines` go: one entry per window.
struct LineRow {
  float* value;     ///< of the least-squares line through the accepted samples, in the middle; NaN without any line
  float* slope;     ///< per pixel
  float* variance;  ///< of the value, in units of sigma^2
  float* accepted;  ///< samples, 3 to 5; 0 if fewer than three samples are there
  float* middle;    ///< 1: the middle sample is accepted
};

/// Exact least trimmed squares lines through five samples each: the three samples that lie best on a line (ten
/// contrasts), then least squares on all samples within 2.5 deviations of a prediction from them. samples[k][i] is
/// sample k of window i, sigma[i] its noise.
void trimmed_lines(const std::array<const float*, 5>& samples, const float* sigma, int count, const LineRow& out);

/// Where the results of `facets` go: one entry per window. Heights are above the middle sample.
struct FacetRow {
  float* value;  ///< of the least-squares plane, in the middle
  float* slope_x;
  float* slope_y;
  float* variance;  ///< of the value, in units of sigma^2; 0: the samples fix no plane
  float* count;     ///< samples with weight
  float* sse;       ///< sum of squared residuals
  float* largest;   ///< absolute residual
  float *bend_xx, *bend_yy,
      *bend_xy;  ///< coefficients of x^2, y^2, xy; samples that are missing count as if they lay on the plane
};

/// Least-squares planes in 5x5 windows. heights[r][i + c - 2] with weight weights[r][i + c - 2] (0 or 1) is the sample
/// in row r and column c of window i; heights are finite everywhere.
void facets(const std::array<const float*, 5>& heights, const std::array<const float*, 5>& weights, int count,
            const FacetRow& out);

/// Samples that lie within `tolerance` of what one of the four lines through them predicts from two or four
/// neighbours. rows[r][i + c - 2] is the sample in row r and column c of the 5x5 window i, NaN where it is missing.
/// weight: 1, or 0 for what is missing or on no line; height: finite everywhere, of the neighbours where the weight is
/// 0.
void samples_on_lines(const std::array<const float*, 5>& rows, float tolerance, int count, float* weight,
                      float* height);

/// Parts of a 5x5 window that hold its middle: 16 sides of straight edges, 8 quadrants.
inline constexpr int side_count = 24;
bool on_side(int side, int x, int y);

/// How well the samples of one window are described by one plane on each side of an edge.
struct Sides {
  alignas(32) std::array<float, side_count> cost;   ///< chi^2; of the far side at most 7.5 per sample
  alignas(32) std::array<float, side_count> value;  ///< of the near side's plane in the middle
  alignas(32) std::array<float, side_count> slope_x, slope_y;
  alignas(32) std::array<float, side_count> variance;  ///< of the value, in units of the noise squared
  alignas(32) std::array<float, side_count> near_sse;
  alignas(32) std::array<float, side_count> near_count;
};

/// `heights` row by row in units of their noise, above the middle one; where that has weight 0 nothing need agree with
/// it.
void split_window(const std::array<float, 25>& heights, const std::array<float, 25>& weights, Sides& out);

}  // namespace partscribe::geometry
