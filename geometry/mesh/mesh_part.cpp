#include "geometry/mesh/mesh_part.h"

#include <algorithm>

#include "geometry/mesh/mesh_neighbours.h"

namespace partscribe::geometry {

MeshPart part_of(const TriangleMesh& mesh, const std::vector<std::uint32_t>& triangles) {
  MeshPart part;
  for (const auto t : triangles) {
    auto& corners = part.mesh.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = mesh.triangles[t][k];
      const auto [at, is_new] = part.local.try_emplace(v, static_cast<std::uint32_t>(part.mesh.vertices.size()));
      if (is_new) part.mesh.vertices.push_back(mesh.vertices[v]);
      corners[k] = at->second;
    }
  }
  return part;
}

std::vector<std::vector<std::uint32_t>> connected_pieces(const std::vector<std::array<std::uint32_t, 3>>& neighbours) {
  std::vector<char> taken(neighbours.size(), 0);
  std::vector<std::vector<std::uint32_t>> result;
  for (std::uint32_t t = 0; t < neighbours.size(); ++t) {
    if (taken[t]) continue;
    auto& piece = result.emplace_back(1, t);
    taken[t] = 1;
    for (std::size_t i = 0; i < piece.size(); ++i)
      for (const auto other : neighbours[piece[i]])
        if (other != no_neighbour && !taken[other]) taken[other] = 1, piece.push_back(other);
    std::sort(piece.begin(), piece.end());
  }
  return result;
}

}  // namespace partscribe::geometry
