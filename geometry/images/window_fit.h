/// Least-squares planes and quadrics in one 5x5 window of a range image.
#pragma once

#include <array>

#include "geometry/images/rlts_filter.h"

namespace partscribe::geometry {

/// Heights above the middle sample, or weights (0 or 1), row by row.
using Window = std::array<float, 25>;

/// In units of the noise; x runs along the row, y down the rows, in pixels from the middle.
struct WindowFacet {
  float value = 0, slope_x = 0, slope_y = 0;
  float variance = 0;  ///< of the value
  RltsModel model = RltsModel::raw;
  float cost = 0;   ///< chi^2 of the window, and what more terms cost
  float doubt = 0;  ///< variance that a crease or bend which hides in the noise may add
};

struct WindowFit {
  WindowFacet facet;            ///< model raw: too few samples
  float sse = 0;                ///< sum of squared residuals
  std::array<float, 3> bend{};  ///< coefficients of x^2, xy, y^2
  bool good = false;            ///< the middle sample agrees with the others within three deviations
  float at(int x, int y) const;
};

WindowFit plane_fit(const Window& heights, const Window& weights);
WindowFit quadric_fit(const Window& heights, const Window& weights);

}  // namespace partscribe::geometry
