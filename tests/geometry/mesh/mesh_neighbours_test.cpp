#include "geometry/mesh/mesh_neighbours.h"

#include <catch2/catch.hpp>

namespace partscribe::geometry {

TEST_CASE("mesh neighbours: each triangle knows the one beyond each edge, and where there is none") {
  const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  const auto neighbours = mesh_neighbours(mesh);
  REQUIRE(neighbours.size() == 2);
  CHECK(neighbours[0] == std::array<std::uint32_t, 3>{no_neighbour, no_neighbour, 1});
  CHECK(neighbours[1] == std::array<std::uint32_t, 3>{0, no_neighbour, no_neighbour});
}

}  // namespace partscribe::geometry
