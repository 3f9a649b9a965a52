/// Triangles of points of a plane: none has another point in its circle, and together they fill the hull.
#include "geometry/mesh/plane_delaunay.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"

using namespace partscribe::geometry;

namespace {

double twice_area(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

}  // namespace

TEST_CASE("plane delaunay: no circle holds another point, and the triangles fill the square") {
  Random random(3);
  std::vector<Vec2> points{{0, 0}, {10, 0}, {10, 10}, {0, 10}};
  for (int k = 0; k < 150; ++k) points.emplace_back(random.uniform(0.01, 9.99), random.uniform(0.01, 9.99));
  const auto triangles = delaunay_triangles(points);
  CHECK(triangles.size() == 2 * points.size() - 2 - 4);
  double area = 0;
  for (const auto& t : triangles) {
    const Vec2 &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
    REQUIRE(twice_area(a, b, c) > 0);
    area += 0.5 * twice_area(a, b, c);
    Eigen::Matrix2d sides;
    sides << (b - a).transpose(), (c - a).transpose();
    const Vec2 middle = a + sides.inverse() * Vec2(0.5 * (b - a).squaredNorm(), 0.5 * (c - a).squaredNorm());
    for (const Vec2& p : points) CHECK((p - middle).norm() > (a - middle).norm() - 1e-9);
  }
  CHECK(area == Approx(100));
}

TEST_CASE("plane delaunay: points that are equal count once, points on a line make no triangle") {
  CHECK(delaunay_triangles({}).empty());
  CHECK(delaunay_triangles({{0, 0}, {1, 1}, {2, 2}, {5, 5}}).empty());
  const auto triangles = delaunay_triangles({{0, 0}, {1, 0}, {0, 0}, {0, 1}, {1, 0}});
  REQUIRE(triangles.size() == 1);
  CHECK(triangles[0] == std::array<std::uint32_t, 3>{0, 1, 3});
}
