/// Deriche's recursive derivative of range images, and the step and roof edges that it shows.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/images/rlts_filter.h"

namespace partscribe::geometry {

/// Derivatives along rows (x) and columns (y), per pixel, row by row; NaN where there is no value.
struct Gradient {
  std::vector<double> x, y;
};

/// Derivative smoothed across (Deriche 1990), with gain 1 on a ramp up to the ends. Larger alpha follows the image,
/// smaller the surface. Each run of values in a row or column is filtered alone; NaN ends it.
Gradient deriche_gradient(const std::vector<double>& values, int width, int height, double alpha);

enum class RangeEdge : std::uint8_t { none, step, roof };

struct EdgeOptions {
  double alpha = 1;
  double low = 3, high = 6;  ///< deviations by which an edge stands out, everywhere and at least somewhere
};

/// Steps are ridges of the depth's slope; roofs are ridges of the slope's change that belong to no step. Both are one
/// or two pixels wide. What counts is how far a ridge stands out from both its sides, so that neither slopes nor round
/// surfaces are edges. Single rejected pixels are bridged; where there is no return everything ends, and so the border
/// of the part is no edge here.
std::vector<RangeEdge> range_edges(const RangeImage& image, const FilteredImage& filtered, const EdgeOptions& options);

}  // namespace partscribe::geometry
