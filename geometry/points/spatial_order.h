/// An order of points in which neighbours in the list are neighbours in space.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::geometry {

/// Indices of `points` along a Hilbert curve through their bounding box; the same for any number of threads.
std::vector<std::uint32_t> spatial_order(std::span<const Vec3> points, int threads);

}  // namespace partscribe::geometry
