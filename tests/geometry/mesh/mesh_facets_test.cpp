/// Normals, edges and pieces of small meshes whose answers are known.
#include "geometry/mesh/mesh_facets.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"

using namespace partscribe::geometry;

namespace {

/// A tetrahedron with legs of `edge` mm along the axes from `corner`, appended to `mesh`.
void add_tetrahedron(TriangleMesh& mesh, const Vec3& corner, double edge, bool inward = false) {
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(corner);
  for (int k = 0; k < 3; ++k) mesh.vertices.push_back(corner + edge * Vec3::Unit(k));
  for (std::array<std::uint32_t, 3> t : {std::array{0u, 2u, 1u}, {0u, 1u, 3u}, {0u, 3u, 2u}, {1u, 2u, 3u}}) {
    if (inward) std::swap(t[1], t[2]);
    mesh.triangles.push_back({base + t[0], base + t[1], base + t[2]});
  }
}

/// The walls of an n-sided prism about z, two triangles each, open at both ends.
TriangleMesh prism_walls(int n, double radius) {
  TriangleMesh mesh;
  for (int i = 0; i < n; ++i)
    for (const double z : {0.0, 10.0})
      mesh.vertices.emplace_back(radius * std::cos(2 * pi * i / n), radius * std::sin(2 * pi * i / n), z);
  for (int i = 0; i < n; ++i) {
    const auto a = static_cast<std::uint32_t>(2 * i), b = static_cast<std::uint32_t>(2 * ((i + 1) % n));
    mesh.triangles.push_back({a, b, b + 1});
    mesh.triangles.push_back({a, b + 1, a + 1});
  }
  return mesh;
}

}  // namespace

TEST_CASE("mesh facets: normals look outward, and a triangle without area has none") {
  TriangleMesh mesh;
  add_tetrahedron(mesh, {1, 2, 3}, 6);
  mesh.triangles.push_back({0, 1, 1});
  const auto normals = triangle_normals(mesh);
  CHECK((normals[0] + Vec3::UnitZ()).norm() < 1e-12);
  CHECK((normals[3] - Vec3(1, 1, 1).normalized()).norm() < 1e-12);
  CHECK(normals[4] == Vec3(0, 0, 0));
}

TEST_CASE("mesh facets: the edges of a closed mesh have two sides that run against each other, the rim has one") {
  TriangleMesh mesh;
  add_tetrahedron(mesh, {0, 0, 0}, 1);
  std::size_t edges = 0, opposite = 0;
  for_each_edge(edge_uses(mesh.triangles), [&](std::span<const EdgeUse> around) {
    ++edges;
    opposite += around.size() == 2 && around[0].from() == around[1].to() && around[0].to() == around[1].from();
  });
  CHECK(edges == 6);
  CHECK(opposite == 6);
  mesh.triangles.pop_back();
  std::size_t rim = 0;
  for_each_edge(edge_uses(mesh.triangles), [&](std::span<const EdgeUse> around) {
    rim += around.size() == 1;
    for (const EdgeUse& use : around) {
      const auto& t = mesh.triangles[use.triangle];
      CHECK(use.from() == t[use.side]);
      CHECK(use.to() == t[(use.side + 1) % 3]);
      CHECK(use.key == edge_key(use.to(), use.from()));
    }
  });
  CHECK(rim == 3);
}

TEST_CASE("mesh facets: pieces have their own area and volume, a cavity a negative one") {
  TriangleMesh mesh;
  mesh.vertices.push_back({9, 9, 9});  // that no triangle uses
  add_tetrahedron(mesh, {100, 0, 0}, 6);
  add_tetrahedron(mesh, {100.5, 0.5, 0.5}, 3, true);
  const MeshPieces pieces = pieces_of(mesh);
  REQUIRE(pieces.volume.size() == 2);
  CHECK(pieces.of == std::vector<std::uint32_t>{0, 0, 0, 0, 1, 1, 1, 1});
  CHECK(pieces.volume[0] == Approx(36));
  CHECK(pieces.volume[1] == Approx(-4.5));
  CHECK(pieces.area[0] + pieces.area[1] == Approx(area(mesh)));
  // One common vertex makes them one piece.
  for (auto& t : mesh.triangles)
    for (auto& v : t)
      if (v == 5) v = 2;
  CHECK(pieces_of(mesh).volume.size() == 1);
}

TEST_CASE(
    "chord depths: the walls of a prism lie as far below their cylinder as its sagitta, those of a block nowhere") {
  for (const int n : {20, 32, 50}) {
    const double sagitta = 15 * (1 - std::cos(pi / n));
    for (const double d : chord_depths(prism_walls(n, 15))) CHECK(d == Approx(sagitta).epsilon(0.02));
  }
  for (const double d : chord_depths(prism_walls(4, 15))) CHECK(d == 0);
}
