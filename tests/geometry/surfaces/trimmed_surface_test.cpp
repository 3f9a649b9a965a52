#include "geometry/surfaces/trimmed_surface.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/number.h"

namespace partscribe::geometry {
namespace {

NurbsCurve<2> line(const Vec2& a, const Vec2& b) { return {clamped(1, {0, 1}), {a, b}, {}}; }

NurbsCurve<2> circle(const Vec2& center, double radius, bool counter_clockwise) {
  NurbsCurve<2> c{{2, {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4}}, {}, {}};
  for (int k = 0; k <= 8; ++k) {
    const double angle = (counter_clockwise ? k : -k) * pi / 4, reach = radius * (k % 2 ? std::sqrt(2.0) : 1);
    c.points.push_back(center + reach * Vec2(std::cos(angle), std::sin(angle)));
    c.weights.push_back(k % 2 ? std::sqrt(0.5) : 1);
  }
  return c;
}

/// z = x y / 50 over (0 .. 40) x (0 .. 30), u and v in mm.
NurbsSurface saddle() {
  NurbsSurface s{clamped(3, {0, 40}), clamped(3, {0, 30}), {}, {}};
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      const double x = 40.0 * i / 3, y = 10.0 * j;
      s.points.emplace_back(x, y, x * y / 50);
    }
  return s;
}

std::vector<SurfaceTrim> rectangle(const Vec2& low, const Vec2& high, std::array<int, 4> edges) {
  const Vec2 b(high.x(), low.y()), d(low.x(), high.y());
  return {{line(low, b), edges[0]}, {line(b, high), edges[1]}, {line(high, d), edges[2]}, {line(d, low), edges[3]}};
}

/// One side of a cube of 20, its parameters mm along two axes, seen from outside.
TrimmedSurface side(const Vec3& corner, const Vec3& along_u, const Vec3& along_v, std::array<int, 4> edges) {
  NurbsSurface s{clamped(1, {0, 20}), clamped(1, {0, 20}), {}, {}};
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) s.points.push_back(corner + 20 * (i * along_u + j * along_v));
  return {s, {rectangle({0, 0}, {20, 20}, edges)}};
}

std::vector<TrimmedSurface> cube() {
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ(), o = Vec3::Zero();
  // Edges: bottom 0 front, 1 right, 2 back, 3 left; top 4 .. 7 likewise; uprights 8 front left, 9, 10, 11.
  return {
      side(o, y, x, {3, 2, 1, 0}),       side(20 * z, x, y, {4, 5, 6, 7}),          side(o, x, z, {0, 9, 4, 8}),
      side(20 * x, y, z, {1, 10, 5, 9}), side(20 * (x + y), -x, z, {2, 11, 6, 10}), side(20 * y, -y, z, {3, 8, 7, 11})};
}

}  // namespace

TEST_CASE("trimmed surface: triangles fill the loops, leave out the hole, and lie on the surface") {
  const TrimmedSurface trimmed{saddle(),
                               {rectangle({2, 3}, {38, 28}, {0, 1, 2, 3}), {{circle({20, 15}, 6, false), 4}}}};
  for (const double deviation : {0.1, 0.01}) {
    const auto made = triangulated(std::span(&trimmed, 1), deviation);
    const auto topo = topology(made.mesh);
    CHECK(topo.nonmanifold_edges == 0);
    CHECK(topo.inconsistent_edges == 0);
    CHECK(topo.components == 1);
    CHECK(made.deviation < deviation);
    double flat = 0;
    for (std::size_t t = 0; t < made.mesh.triangles.size(); ++t) {
      const auto& at = made.place[t];
      flat += 0.5 * ((at[1] - at[0]).x() * (at[2] - at[0]).y() - (at[1] - at[0]).y() * (at[2] - at[0]).x());
      const Vec3 up = triangle_normal(made.mesh, t);
      CHECK(up.z() > 0.5);
    }
    CHECK(flat == Approx(36 * 25 - pi * 36).epsilon(std::sqrt(deviation) / 10));
    for (const Vec3& p : made.mesh.vertices) CHECK(p.z() == Approx(p.x() * p.y() / 50).margin(1e-12));
  }
}

TEST_CASE("trimmed surface: loops that cross or are no numbers give some triangles or none, and nothing worse") {
  // A bow tie, and a hole that reaches out of its outline.
  const std::vector<SurfaceTrim> bow = {{line({5, 5}, {30, 25}), 0},
                                        {line({30, 25}, {30, 5}), 1},
                                        {line({30, 5}, {5, 25}), 2},
                                        {line({5, 25}, {5, 5}), 3}};
  const TrimmedSurface crossed{saddle(), {bow}};
  const auto made = triangulated(std::span(&crossed, 1), 0.1);
  for (const auto& t : made.mesh.triangles)
    for (const auto v : t) CHECK(v < made.mesh.vertices.size());
  const TrimmedSurface reaching{saddle(),
                                {rectangle({2, 3}, {38, 28}, {0, 1, 2, 3}), {{circle({36, 15}, 6, false), 4}}}};
  CHECK_FALSE(triangulated(std::span(&reaching, 1), 0.1).mesh.empty());
  TrimmedSurface broken{saddle(), {rectangle({2, 3}, {38, 28}, {0, 1, 2, 3})}};
  broken.surface.points[5].x() = std::numeric_limits<double>::quiet_NaN();
  CHECK(triangulated(std::span(&broken, 1), 0.1).mesh.empty());
  // A border that goes to and fro on one line, and one that stays in a place.
  for (const Vec2& high : {Vec2(38, 3), Vec2(2, 3)}) {
    const TrimmedSurface flat{saddle(), {rectangle({2, 3}, high, {0, 1, 2, 3})}};
    CHECK(triangulated(std::span(&flat, 1), 0.1).mesh.empty());
  }
}

TEST_CASE("trimmed surface: surfaces with common edges become one closed mesh") {
  const auto surfaces = cube();
  const auto made = triangulated(surfaces, 0.1);
  CHECK(topology(made.mesh).closed());
  CHECK(volume(made.mesh) == Approx(8000));
  CHECK(made.mesh.vertices.size() >= 8);
}

TEST_CASE("trimmed surface: two surfaces with the same border have no inner edge in common") {
  // A cushion: both sides cut the same corners off the same square.
  std::vector<TrimmedSurface> cushion(2, {saddle(), {rectangle({0, 0}, {40, 30}, {0, 1, 2, 3})}});
  for (std::size_t k = 0; k < 2; ++k)
    for (const std::size_t inner : {5, 6, 9, 10}) cushion[k].surface.points[inner].z() += k == 0 ? 4 : -4;
  cushion[1] = turned_over(cushion[1]);
  const auto made = triangulated(cushion, 4);
  const auto topo = topology(made.mesh);
  CHECK(topo.closed());
  CHECK(topo.components == 1);
  CHECK(made.place.size() == made.mesh.triangles.size());
  CHECK(made.patch.size() == made.mesh.triangles.size());
  for (std::size_t t = 0; t < made.mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2& uv = made.place[t][k];
      CHECK((made.mesh.corner(t, int(k)) - cushion[made.patch[t]].surface.at(uv.x(), uv.y())).norm() < 1e-9);
    }
}

TEST_CASE("trimmed surface: distances end on the surface inside of the loops and on their border outside") {
  const TrimmedSurface trimmed{saddle(),
                               {rectangle({0, 0}, {40, 30}, {0, 1, 2, 3}), {{circle({20, 15}, 6, false), 4}}}};
  const SurfaceDistance distance({trimmed}, 0.01, false);
  for (const auto& [u, v] : {std::pair{5.0, 5.0}, {33.0, 21.0}, {20.0, 25.0}}) {
    const SurfacePoint at = trimmed.surface.derivatives(u, v);
    for (const double lift : {-1.5, 0.002, 2.0}) {
      const auto hit = distance(at.p + lift * at.normal());
      CHECK(hit.distance == Approx(lift).epsilon(1e-9));
      CHECK((hit.point - at.p).norm() < 1e-6);
      CHECK((hit.normal - at.normal()).norm() < 1e-6);
    }
  }
  // Over the middle of the hole: its rim is 6 mm away in the parameter plane and a little farther in space.
  CHECK(std::abs(distance(trimmed.surface.at(20, 15)).distance) == Approx(6).epsilon(0.05));
  CHECK(std::abs(distance(Vec3(-3, 15, 0)).distance) == Approx(3).margin(0.01));
}

TEST_CASE("trimmed surface: distances inside of a closed body are negative") {
  const SurfaceDistance distance(cube(), 0.01, true);
  CHECK(distance({10, 10, 10}).distance == Approx(-10));
  CHECK(distance({10, 10, 19.5}).distance == Approx(-0.5));
  CHECK(distance({10, 10, 20.001}).distance == Approx(0.001));
  CHECK(distance({23, 24, 10}).distance == Approx(5));
}

}  // namespace partscribe::geometry
