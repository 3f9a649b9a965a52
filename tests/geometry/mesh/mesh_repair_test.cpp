#include "geometry/mesh/mesh_repair.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"

using namespace partscribe::geometry;

namespace {

/// A box as twelve triangles with vertices of its own, appended to `mesh`.
void add_box(TriangleMesh& mesh, const Vec3& low, const Vec3& high, bool inward = false) {
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back({i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z()});
  const std::array<std::array<std::uint32_t, 4>, 6> faces = {
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& f : faces)
    for (const auto& t :
         {std::array<std::uint32_t, 3>{f[0], f[1], f[2]}, std::array<std::uint32_t, 3>{f[0], f[2], f[3]}}) {
      if (inward)
        mesh.triangles.push_back({base + t[0], base + t[2], base + t[1]});
      else
        mesh.triangles.push_back({base + t[0], base + t[1], base + t[2]});
    }
}

/// Every triangle with corners of its own, as STL has them.
TriangleMesh soup(const TriangleMesh& mesh) {
  TriangleMesh result;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto base = static_cast<std::uint32_t>(result.vertices.size());
    for (int k = 0; k < 3; ++k) result.vertices.push_back(mesh.corner(t, k));
    result.triangles.push_back({base, base + 1, base + 2});
  }
  return result;
}

/// Every vertex has one fan of triangles.
bool manifold_vertices(const TriangleMesh& mesh) {
  const RepairReport again = repair(mesh, {.min_component = 0, .small_hole = 0, .flat_hole = 0});
  return again.split_vertices == 0;
}

}  // namespace

TEST_CASE("mesh repair: a soup with turned, double and collapsed triangles becomes one solid") {
  TriangleMesh box;
  add_box(box, {0, 0, 0}, {2, 3, 4});
  TriangleMesh bad = soup(box);
  for (const std::size_t t : {1u, 5u, 6u}) std::swap(bad.triangles[t][0], bad.triangles[t][1]);
  bad.triangles.push_back(bad.triangles[3]);
  bad.triangles.push_back({0, 0, 1});
  const RepairReport report = repair(bad, {});
  CHECK(report.closed);
  CHECK(report.mesh.vertices.size() == 8);
  CHECK(report.mesh.triangles.size() == 12);
  CHECK(report.degenerate == 2);
  CHECK(volume(report.mesh) == Approx(24));
}

TEST_CASE("mesh repair: an inside-out solid is turned, a cavity stays one") {
  TriangleMesh hollow;
  add_box(hollow, {0, 0, 0}, {10, 10, 10}, true);
  add_box(hollow, {3, 3, 3}, {7, 7, 7});
  const RepairReport report = repair(hollow, {});
  CHECK(report.closed);
  CHECK(volume(report.mesh) == Approx(1000 - 64));
}

TEST_CASE("mesh repair: two solids that touch in an edge or in a corner are separated") {
  for (const bool corner_only : {false, true}) {
    TriangleMesh two;
    add_box(two, {0, 0, 0}, {1, 1, 1});
    add_box(two, {1, 1, corner_only ? 1.0 : 0.0}, {2, 2, corner_only ? 2.0 : 1.0});
    const RepairReport report = repair(two, {.separation = 0.001});
    CHECK(report.split_vertices == (corner_only ? 1 : 2));
    CHECK(report.closed);
    CHECK(topology(report.mesh).components == 2);
    CHECK(manifold_vertices(report.mesh));
    CHECK(volume(report.mesh) == Approx(2).epsilon(0.005));
  }
}

TEST_CASE("mesh repair: holes are filled where they are small or flat, a sheet stays a sheet") {
  TriangleMesh box;
  add_box(box, {0, 0, 0}, {4, 4, 4});
  box.triangles.erase(box.triangles.begin(), box.triangles.begin() + 2);
  const RepairReport filled = repair(box, {});
  CHECK(filled.closed);
  CHECK(filled.filled_holes == 1);
  CHECK(filled.filled_area == Approx(16));
  CHECK(volume(filled.mesh) == Approx(64));

  TriangleMesh sheet;
  sheet.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const RepairReport open = repair(sheet, {});
  CHECK_FALSE(open.closed);
  CHECK(open.open_holes == 1);
  CHECK(open.mesh.triangles.size() == 2);
}

TEST_CASE("mesh repair: specks that float about are dropped and counted") {
  TriangleMesh mesh;
  add_box(mesh, {0, 0, 0}, {100, 100, 100});
  add_box(mesh, {120, 0, 0}, {120.5, 0.5, 0.5});
  add_box(mesh, {130, 0, 0}, {130.5, 0.5, 0.5});
  const RepairReport report = repair(mesh, {});
  CHECK(report.dropped_components == 2);
  CHECK(report.dropped_area == Approx(3));
  CHECK(volume(report.mesh) == Approx(1e6));
}

TEST_CASE("mesh repair: a fin on an edge leaves a closed solid or an honest open mesh") {
  TriangleMesh mesh;
  add_box(mesh, {0, 0, 0}, {4, 4, 4});
  mesh.vertices.push_back({2, -3, 0});
  mesh.triangles.push_back({0, 1, 8});
  const RepairReport report = repair(mesh, {});
  const MeshTopology result = topology(report.mesh);
  CHECK(result.nonmanifold_edges == 0);
  CHECK(result.inconsistent_edges == 0);
  CHECK(report.closed == result.closed());
}

TEST_CASE("mesh repair: no triangles at all are no solid") {
  const RepairReport report = repair(TriangleMesh{}, {});
  CHECK_FALSE(report.closed);
  CHECK(report.mesh.empty());
}
