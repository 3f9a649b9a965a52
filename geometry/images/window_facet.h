/// The surface under one pixel of a range image where one plane does not describe its 5x5 window.
#pragma once

#include "geometry/images/window_fit.h"

namespace partscribe::geometry {

/// The likeliest of: a plane through all samples, a quadric through all, a plane or quadric on the middle's own side
/// of an edge. More terms must pay with chi^2 beyond the 99.9 % point. Model raw: the middle agrees with none. `firm`:
/// the middle is known to lie on a surface, so that it need not be better explained as an outlier between two planes.
WindowFacet window_facet(const Window& heights, const Window& weights, bool firm);

}  // namespace partscribe::geometry
