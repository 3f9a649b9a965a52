/// Points chosen from a cloud, with everything that is known of them.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/point_cloud.h"

namespace partscribe {

/// Drops every point i with keep[i] == 0 from all columns; `keep` is as long as the cloud. The others keep their order.
void keep_points(PointCloud& cloud, const std::vector<std::uint8_t>& keep);

}  // namespace partscribe
