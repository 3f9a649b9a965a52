/// The Delaunay triangulation of points of a plane.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::geometry {

/// Indices of `points`, counter-clockwise, sorted; none if all points are on one line. Of equal points the first
/// counts. No triangle's circle has another point inside; of four points on one circle the answer is one of two, the
/// same for the same points.
std::vector<std::array<std::uint32_t, 3>> delaunay_triangles(const std::vector<Vec2>& points);

}  // namespace partscribe::geometry
