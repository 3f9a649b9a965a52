/// Finds triangles of a mesh that pass through each other.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace partscribe {

/// Pairs of triangles that cross (an edge of one passes through the inside of the other), smaller index first, sorted;
/// at most `limit` of them. Triangles that share an edge do not count, nor do coplanar ones.
std::vector<std::pair<std::uint32_t, std::uint32_t>> self_intersections(const TriangleMesh& mesh,
                                                                        std::size_t limit = 1000);

}  // namespace partscribe
