#include "geometry/mesh/mesh_part.h"

#include <catch2/catch.hpp>

#include "geometry/mesh/mesh_neighbours.h"

namespace partscribe::geometry {

TEST_CASE("mesh part: connected pieces, each as a mesh of its own") {
  // Two triangles with an edge in common, and one that touches them at a vertex only.
  const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 1, 0}, {2, 2, 0}},
                          {{0, 1, 2}, {2, 4, 5}, {0, 2, 3}}};
  const auto pieces = connected_pieces(mesh_neighbours(mesh));
  REQUIRE(pieces == std::vector<std::vector<std::uint32_t>>{{0, 2}, {1}});
  const MeshPart part = part_of(mesh, pieces[1]);
  CHECK(part.mesh.triangles == std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}});
  CHECK(part.mesh.vertices[0] == mesh.vertices[2]);
  CHECK(part.local.at(5) == 2);
}

}  // namespace partscribe::geometry
