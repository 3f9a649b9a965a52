#include "geometry/mesh/surface_walk.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "geometry/mesh/mesh_distance.h"

using namespace partscribe::geometry;

namespace {

/// Twenty by twenty squares, in the middle of which a ridge goes up along y.
TriangleMesh ridge(double height) {
  TriangleMesh mesh;
  constexpr std::uint32_t n = 20;
  for (std::uint32_t i = 0; i <= n; ++i)
    for (std::uint32_t j = 0; j <= n; ++j) mesh.vertices.push_back({1.0 * i, 1.0 * j, i == n / 2 ? height : 0});
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t a = i * (n + 1) + j, b = a + n + 1;
      mesh.triangles.push_back({a, b, b + 1});
      mesh.triangles.push_back({a, b + 1, a + 1});
    }
  return mesh;
}

Walk walk(const TriangleMesh& mesh, const Vec3& a, const Vec3& b, double bound) {
  const MeshDistance distance(mesh);
  const SurfaceWalk surface(mesh);
  const auto place = [&](const Vec3& p) {
    const MeshHit hit = distance.closest(p);
    return surface.inside(hit.triangle, hit.point);
  };
  return surface.along(a, place(a), b, place(b), bound);
}

}  // namespace

TEST_CASE("surface walk: a segment over a ridge is as far from the surface as the ridge is high") {
  const TriangleMesh mesh = ridge(0.4);
  for (const double y : {10.0, 9.3}) {  // along edges and through corners, or between them
    CHECK(walk(mesh, {2, 10, 0}, {18, y, 0}, 0.401) == Walk::within);
    CHECK(walk(mesh, {2, 10, 0}, {18, y, 0}, 0.397) == Walk::beyond);
    CHECK(walk(mesh, {18, y, 0}, {2, 10, 0}, 0.397) == Walk::beyond);
  }
  CHECK(walk(mesh, {2, 3, 0.1}, {9, 17, 0.1}, 0.11) == Walk::within);
}

TEST_CASE("surface walk: a border in the way is no answer") {
  TriangleMesh mesh = ridge(0);
  std::erase_if(mesh.triangles, [&](const auto& t) { return t[0] / 21 == 10; });  // a slot along y
  CHECK(walk(mesh, {2, 10, 0}, {18, 10.3, 0}, 0.5) == Walk::ended);
  CHECK(walk(mesh, {2, 10, 0}, {9, 10.3, 0}, 0.5) == Walk::within);
}
