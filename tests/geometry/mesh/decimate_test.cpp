#include "geometry/mesh/decimate.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/mesh/self_intersection.h"

using namespace partscribe::geometry;

namespace {

/// A unit cube's faces in n x n squares each, points moved by `shape`.
template <class Shape>
TriangleMesh gridded_cube(std::uint32_t n, Shape&& shape) {
  TriangleMesh mesh;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    const double side = face % 2 ? 1 : -1;
    const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::uint32_t i = 0; i <= n; ++i)
      for (std::uint32_t j = 0; j <= n; ++j) {
        Vec3 p;
        p[axis] = side;
        p[(axis + 1) % 3] = -1 + 2.0 * i / n;
        p[(axis + 2) % 3] = -1 + 2.0 * j / n;
        mesh.vertices.push_back(shape(p));
      }
    for (std::uint32_t i = 0; i < n; ++i)
      for (std::uint32_t j = 0; j < n; ++j) {
        const std::uint32_t a = base + i * (n + 1) + j, b = a + n + 1, c = b + 1, d = a + 1;
        if (side > 0) {
          mesh.triangles.push_back({a, b, c});
          mesh.triangles.push_back({a, c, d});
        } else {
          mesh.triangles.push_back({a, c, b});
          mesh.triangles.push_back({a, d, c});
        }
      }
  }
  return welded(mesh, 1e-9);
}

/// The farthest of random points of `from` from the surface of `to`.
double farthest(const TriangleMesh& from, const TriangleMesh& to) {
  const MeshDistance distance(to);
  Random random(17);
  double worst = 0;
  for (const Vec3& v : from.vertices) worst = std::max(worst, distance.closest(v).distance);
  const std::size_t each = 1 + 20000 / from.triangles.size();
  for (std::size_t t = 0; t < from.triangles.size(); ++t)
    for (std::size_t k = 0; k < each; ++k) {
      double u = random.uniform(), v = random.uniform();
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const Vec3 p = from.corner(t, 0) * (1 - u - v) + from.corner(t, 1) * u + from.corner(t, 2) * v;
      worst = std::max(worst, distance.closest(p).distance);
    }
  return worst;
}

}  // namespace

TEST_CASE("decimate: a finely gridded cube becomes twelve triangles") {
  Context context;
  const TriangleMesh cube = gridded_cube(20, [](const Vec3& p) { return Vec3(10 * p); });
  const TriangleMesh small = decimated(cube, {.max_error = 0.01}, context);
  CHECK(small.triangles.size() == 12);
  CHECK(topology(small).closed());
  CHECK(volume(small) == Approx(8000).epsilon(1e-4));
}

TEST_CASE("decimate: both surfaces stay within the bound of each other, and the ball stays closed") {
  Context context;
  const TriangleMesh ball = gridded_cube(30, [](const Vec3& p) { return Vec3(10 * p.normalized()); });
  std::size_t last = ball.triangles.size();
  for (const double bound : {0.02, 0.1, 0.5}) {
    const TriangleMesh small = decimated(ball, {.max_error = bound}, context);
    INFO("bound " << bound << ", triangles " << small.triangles.size());
    CHECK(topology(small).closed());
    CHECK(topology(small).components == 1);
    CHECK(volume(small) > 0);
    CHECK(farthest(ball, small) <= bound);
    CHECK(farthest(small, ball) <= bound);
    CHECK(small.triangles.size() < last);
    last = small.triangles.size();
  }
  CHECK(last < 120);
}

TEST_CASE("decimate: a bumpy open sheet keeps its border") {
  Context context;
  TriangleMesh sheet;
  const std::uint32_t n = 40;
  for (std::uint32_t i = 0; i <= n; ++i)
    for (std::uint32_t j = 0; j <= n; ++j)
      sheet.vertices.push_back({1.0 * i, 1.0 * j, std::sin(0.3 * i) * std::cos(0.2 * j)});
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t a = i * (n + 1) + j, b = a + n + 1;
      sheet.triangles.push_back({a, b, b + 1});
      sheet.triangles.push_back({a, b + 1, a + 1});
    }
  const TriangleMesh small = decimated(sheet, {.max_error = 0.05}, context);
  const MeshTopology result = topology(small);
  CHECK(result.nonmanifold_edges == 0);
  CHECK(result.inconsistent_edges == 0);
  CHECK(result.components == 1);
  CHECK(result.boundary_edges > 3);
  CHECK(small.triangles.size() < sheet.triangles.size() / 3);
  CHECK(farthest(sheet, small) <= 0.05);
  CHECK(farthest(small, sheet) <= 0.05);
}

TEST_CASE("decimate: a wall thinner than the bound is not folded through itself") {
  Context context;
  const TriangleMesh wall = gridded_cube(16, [](const Vec3& p) { return Vec3(10 * p.x(), 10 * p.y(), 0.1 * p.z()); });
  const TriangleMesh small = decimated(wall, {.max_error = 0.15}, context);
  CHECK(topology(small).closed());
  CHECK(volume(small) > 20);
}

TEST_CASE("decimate: rough walls closer together than the bound do not come to cross each other") {
  Context context;
  // A cup turned from a profile, its wall 0.3 mm thick.
  const std::vector<std::array<double, 2>> corners = {{0, 0}, {8, 0}, {8, 8}, {7.7, 8}, {7.7, 0.4}, {0, 0.4}};
  constexpr std::uint32_t around = 200;
  Random random(3);
  TriangleMesh cup;
  std::vector<std::array<double, 2>> profile;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const auto [r, z] = corners[i];
    const double dr = corners[i + 1][0] - r, dz = corners[i + 1][1] - z;
    const int steps = std::max(1, int(std::hypot(dr, dz) / 0.25));
    for (int k = i == 0 ? 1 : 0; k < steps; ++k) profile.push_back({r + dr * k / steps, z + dz * k / steps});
  }
  for (const auto& [r, z] : profile) {
    const auto rough = [&, noise = 0.02 * r / 8] { return noise * random.normal(); };
    for (std::uint32_t k = 0; k < around; ++k) {
      const double angle = 2 * pi * k / around;
      cup.vertices.push_back(Vec3((r + rough()) * std::cos(angle), (r + rough()) * std::sin(angle), z + rough()));
    }
  }
  const auto rings = static_cast<std::uint32_t>(profile.size());
  cup.vertices.push_back(Vec3(0, 0, 0)), cup.vertices.push_back(Vec3(0, 0, 0.4));
  for (std::uint32_t k = 0; k < around; ++k) {
    const std::uint32_t next = (k + 1) % around, top = (rings - 1) * around;
    cup.triangles.push_back({rings * around, next, k});
    cup.triangles.push_back({rings * around + 1, top + k, top + next});
    for (std::uint32_t i = 0; i + 1 < rings; ++i) {
      const std::uint32_t a = i * around + k, b = i * around + next, c = a + around, d = b + around;
      cup.triangles.push_back({a, b, d});
      cup.triangles.push_back({a, d, c});
    }
  }
  REQUIRE(topology(cup).closed());
  REQUIRE(volume(cup) > 0);
  REQUIRE(self_intersections(cup).empty());
  for (const double bound : {0.14, 0.3}) {
    const TriangleMesh small = decimated(cup, {.max_error = bound}, context);
    INFO("bound " << bound << ", triangles " << small.triangles.size());
    CHECK(self_intersections(small).empty());
    CHECK(topology(small).closed());
    CHECK(small.triangles.size() * 6 < cup.triangles.size());
  }
}

TEST_CASE("decimate: equal input gives equal output, and nothing to do changes nothing") {
  Context context;
  const TriangleMesh ball = gridded_cube(12, [](const Vec3& p) { return Vec3(5 * p.normalized()); });
  const TriangleMesh one = decimated(ball, {.max_error = 0.1}, context),
                     two = decimated(ball, {.max_error = 0.1}, context);
  CHECK(one.triangles == two.triangles);
  CHECK(one.vertices == two.vertices);
  TriangleMesh tetrahedron;
  tetrahedron.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  tetrahedron.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  CHECK(decimated(tetrahedron, {.max_error = 100}, context).triangles.size() == 4);
  CHECK(decimated(TriangleMesh{}, {}, context).empty());
}

TEST_CASE("decimate: seventy thousand and half a million triangles", "[.speed]") {
  Context context;
  for (const std::uint32_t n : {77u, 205u}) {
    const TriangleMesh ball = gridded_cube(n, [](const Vec3& p) {
      const Vec3 d = p.normalized();
      return Vec3((20 + std::sin(8 * d.x()) * std::sin(7 * d.y()) * std::sin(6 * d.z())) * d);
    });
    const auto start = std::chrono::steady_clock::now();
    const TriangleMesh small = decimated(ball, {.max_error = 0.04}, context);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    WARN(ball.triangles.size() << " -> " << small.triangles.size() << " in " << seconds << " s, farthest "
                               << farthest(ball, small) << " " << farthest(small, ball));
    CHECK(topology(small).closed());
  }
}
