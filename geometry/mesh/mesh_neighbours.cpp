#include "geometry/mesh/mesh_neighbours.h"

#include <algorithm>

namespace partscribe::geometry {

std::vector<std::array<std::uint32_t, 3>> mesh_neighbours(const TriangleMesh& mesh) {
  struct Half {
    std::uint32_t from, to, triangle, corner;
    bool operator<(const Half& o) const {
      return from != o.from ? from < o.from : to != o.to ? to < o.to : triangle < o.triangle;
    }
  };
  std::vector<Half> halves;
  halves.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::uint32_t k = 0; k < 3; ++k)
      halves.push_back({mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3], t, k});
  std::sort(halves.begin(), halves.end());
  std::vector<std::array<std::uint32_t, 3>> result(mesh.triangles.size(), {no_neighbour, no_neighbour, no_neighbour});
  for (const Half& half : halves) {
    const auto other = std::lower_bound(halves.begin(), halves.end(), Half{half.to, half.from, 0, 0});
    if (other != halves.end() && other->from == half.to && other->to == half.from)
      result[half.triangle][half.corner] = other->triangle;
  }
  return result;
}

}  // namespace partscribe::geometry
