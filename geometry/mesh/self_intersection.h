/// Finds triangles of a mesh that pass through each other.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::geometry {

/// A triangle by the numbers of its corners and where these are.
struct PlacedTriangle {
  std::array<std::uint32_t, 3> vertices{};
  std::array<Vec3, 3> corners;  ///< mm
};

/// Does an edge of one pass through the inside of the other? Triangles that share an edge do not cross, nor do coplanar
/// ones.
bool triangles_cross(const PlacedTriangle& a, const PlacedTriangle& b);

/// Pairs of triangles that cross (an edge of one passes through the inside of the other), smaller index first, sorted;
/// at most `limit` of them. Triangles that share an edge do not count, nor do coplanar ones.
std::vector<std::pair<std::uint32_t, std::uint32_t>> self_intersections(const TriangleMesh& mesh,
                                                                        std::size_t limit = 1000);

}  // namespace partscribe::geometry
