/// Height maps, as profilometers and terrain models write them.
#pragma once

#include <optional>

#include "fit/surface/grid_fit.h"
#include "geometry/points/point_cloud.h"

namespace partscribe::fit {

/// The points of a cloud as one over every pair of two lists of coordinates (y and z, z and x, or x and y), so that u,
/// v and the third are right-handed. Nothing for any other cloud, and where points were set aside.
std::optional<SplineGrid> height_map_of(const PointCloud& cloud);

}  // namespace partscribe::fit
