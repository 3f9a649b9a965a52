/// Parts of a mesh.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::geometry {

/// Some triangles of a mesh as a mesh of their own.
struct MeshPart {
  TriangleMesh mesh;                             ///< in the order that was asked for, vertices as they are met
  std::map<std::uint32_t, std::uint32_t> local;  ///< number of a vertex of the whole mesh in the part
};
MeshPart part_of(const TriangleMesh& mesh, const std::vector<std::uint32_t>& triangles);

/// The triangles of each piece that is connected by `neighbours` (mesh_neighbours, or fewer of them), ascending; pieces
/// by their first triangle.
std::vector<std::vector<std::uint32_t>> connected_pieces(const std::vector<std::array<std::uint32_t, 3>>& neighbours);

}  // namespace partscribe::geometry
