/// Normals of a mesh's edges and corners that tell inside from outside (Baerentzen & Aanaes 2005).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::geometry {

/// Vertices at the same place count as one, so that loose triangles have neighbours too.
struct Pseudonormals {
  std::vector<std::array<std::uint32_t, 3>> edge;  ///< of a triangle's three edges: index into edge_normals
  std::vector<Vec3> edge_normals;                  ///< sums of unit normals
  std::vector<std::uint32_t> united;               ///< of a vertex: index into corner_normals
  std::vector<Vec3> corner_normals;                ///< sums of unit normals weighted by the angle

  const Vec3& of_edge(std::size_t triangle, int k) const { return edge_normals[edge[triangle][std::size_t(k)]]; }
  const Vec3& of_corner(const TriangleMesh& mesh, std::size_t triangle, int k) const {
    return corner_normals[united[mesh.triangles[triangle][std::size_t(k)]]];
  }
};

Pseudonormals pseudonormals(const TriangleMesh& mesh);

}  // namespace partscribe::geometry
