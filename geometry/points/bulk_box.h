/// The box that nearly all points lie in: outliers have no say.
#pragma once

#include <vector>

#include "geometry/vec.h"

namespace partscribe::geometry {

/// Along each axis from the first to the last coordinate (mm) when the share `left_out` of the points is left out at
/// either end; empty for no points. Points that are not finite do not count.
Box3 bulk_box(const std::vector<Vec3>& points, double left_out);

}  // namespace partscribe::geometry
