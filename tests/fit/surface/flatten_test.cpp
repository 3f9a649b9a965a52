#include "fit/surface/flatten.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"

using namespace partscribe::core;
using namespace partscribe::geometry;
using namespace partscribe::fit;

namespace {

/// A grid of columns x rows over 0 .. 1 squared, bent by `place`; a cell may be left out.
template <class Place, class Keep>
TriangleMesh grid(int columns, int rows, const Place& place, const Keep& keep) {
  TriangleMesh mesh;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) mesh.vertices.push_back(place(double(i) / columns, double(j) / rows));
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      if (!keep(i, j)) continue;
      const auto a = std::uint32_t(j * (columns + 1) + i), b = a + 1, c = a + std::uint32_t(columns) + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  return welded(mesh, 0);
}

/// The largest and the smallest ratio of an edge's length in the plane and in space.
std::pair<double, double> stretch(const TriangleMesh& mesh, const std::vector<Vec2>& places) {
  double least = 1e300, most = 0;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = t[k], b = t[(k + 1) % 3];
      const double ratio = (places[a] - places[b]).norm() / (mesh.vertices[a] - mesh.vertices[b]).norm();
      least = std::min(least, ratio), most = std::max(most, ratio);
    }
  return {least, most};
}

std::size_t turned_over(const TriangleMesh& mesh, const std::vector<Vec2>& places) {
  std::size_t count = 0;
  for (const auto& t : mesh.triangles) {
    const Vec2 p = places[t[1]] - places[t[0]], q = places[t[2]] - places[t[0]];
    count += p.x() * q.y() - p.y() * q.x() <= 0;
  }
  return count;
}

const auto all = [](int, int) { return true; };

}  // namespace

TEST_CASE("flatten: what is seen from one direction is seen from there") {
  const auto mesh = grid(
      20, 12, [](double u, double v) { return Vec3(50 * u, 30 * v, 4 * std::sin(5 * u)); }, all);
  const auto places = flattened(mesh);
  REQUIRE(places);
  CHECK(turned_over(mesh, *places) == 0);
  const auto [least, most] = stretch(mesh, *places);
  CHECK(most < 1.0001);
  CHECK(least > 0.8);
}

TEST_CASE("flatten: a cylinder of three quarters of a turn, with a window, unrolls to its true size") {
  const auto mesh = grid(
      60, 20,
      [](double u, double v) {
        const double angle = 1.5 * pi * u;
        return Vec3(20 * std::cos(angle), 20 * std::sin(angle), 40 * v);
      },
      [](int i, int j) { return !(i >= 20 && i < 30 && j >= 6 && j < 13); });
  const auto places = flattened(mesh);
  REQUIRE(places);
  CHECK(turned_over(mesh, *places) == 0);
  const auto [least, most] = stretch(mesh, *places);
  CHECK(most < 1.02);
  CHECK(least > 0.98);
}

TEST_CASE("flatten: more than half a ball is laid out without a triangle turned over") {
  const auto mesh = grid(
      40, 60,
      [](double u, double v) {
        // From the pole down to 115 degrees; the columns meet at the pole.
        const double down = 2.0 * u, around = 2 * pi * (v >= 1 ? 0 : v);
        return Vec3(30 * std::sin(down) * std::cos(around), 30 * std::sin(down) * std::sin(around),
                    30 * std::cos(down));
      },
      all);
  const auto places = flattened(mesh);
  REQUIRE(places);
  CHECK(turned_over(mesh, *places) == 0);
  const auto [least, most] = stretch(mesh, *places);
  CHECK(least > 0.4);
  CHECK(most < 2);
}

TEST_CASE("flatten: border loops run with the surface on their left") {
  const auto mesh = grid(
      10, 8, [](double u, double v) { return Vec3(10 * u, 8 * v, 0); },
      [](int i, int j) { return !(i >= 4 && i < 6 && j >= 3 && j < 5); });
  const auto loops = border_loops(mesh);
  REQUIRE(loops.size() == 2);
  double areas[2] = {};
  for (std::size_t l = 0; l < 2; ++l)
    for (std::size_t i = 0; i < loops[l].size(); ++i) {
      const Vec3 a = mesh.vertices[loops[l][i]], b = mesh.vertices[loops[l][(i + 1) % loops[l].size()]];
      areas[l] += 0.5 * (a.x() * b.y() - a.y() * b.x());
    }
  CHECK(std::max(areas[0], areas[1]) == Approx(80));
  CHECK(std::min(areas[0], areas[1]) == Approx(-4));
}
