/// Least trimmed squares planes and quadrics in 5x5 windows, as the filters of the 1993 paper.
#pragma once

#include "geometry/images/window_fit.h"

namespace partscribe::geometry {

struct TrimmedWindow {
  WindowFacet facet;    ///< least squares over the accepted samples; model raw: too few samples
  bool middle = false;  ///< the middle sample is accepted
};

/// Least trimmed squares over h = (n + p + 1) / 2 of n samples for p = 3 (plane) or 6 (quadric) terms, from 22 parts
/// of the window by concentration steps (Rousseeuw & Van Driessen 2006), then least squares over all samples within
/// 2.5 deviations. Units as in WindowFacet.
TrimmedWindow trimmed_window(const Window& heights, const Window& weights, bool quadric);

}  // namespace partscribe::geometry
