/// Ellipses through points of known ones, and what is none.
#include "geometry/surfaces/ellipse_fit.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"

using namespace partscribe::geometry;

namespace {

std::vector<Vec2> on_ellipse(double a, double b, double angle, const Vec2& center, double from, double to, int count) {
  std::vector<Vec2> points;
  const Vec2 x(std::cos(angle), std::sin(angle)), y(-x.y(), x.x());
  for (int i = 0; i < count; ++i) {
    const double t = from + (to - from) * i / (count - 1);
    points.push_back(center + a * std::cos(t) * x + b * std::sin(t) * y);
  }
  return points;
}

}  // namespace

TEST_CASE("ellipse fit: an ellipse without noise comes back, from an arc as well, wherever it lies") {
  for (const double to : {2 * pi, 1.2})
    for (const double shorter : {9.0, 4.0, 0.7}) {
      const auto found = fitted_ellipse(on_ellipse(10, shorter, 0.7, {500, -300}, 0.2, to, 60));
      REQUIRE(found);
      CHECK((found->center - Vec2(500, -300)).norm() < 1e-3);
      CHECK(found->longer == Approx(10).margin(1e-3));
      CHECK(found->shorter == Approx(shorter).margin(1e-3));
      CHECK(std::abs(found->direction.dot(Vec2(std::cos(0.7), std::sin(0.7)))) == Approx(1).margin(1e-6));
      CHECK(found->mean_radius() == Approx(std::sqrt(10 * shorter)).margin(1e-3));
    }
}

TEST_CASE("ellipse fit: with noise it is an ellipse always, even from points of a parabola") {
  partscribe::core::Random random(2);
  auto points = on_ellipse(10, 6, 0.3, {3, 4}, 0, 2 * pi, 400);
  for (Vec2& p : points) p += 0.1 * Vec2(random.normal(), random.normal());
  const auto found = fitted_ellipse(points);
  REQUIRE(found);
  CHECK((found->center - Vec2(3, 4)).norm() < 0.03);
  CHECK(found->longer == Approx(10).margin(0.05));
  CHECK(found->shorter == Approx(6).margin(0.05));
  CHECK(found->off(Vec2(3, 4) + 12 * found->direction) == Approx(12 - found->longer).margin(0.05));
  CHECK(found->off(found->center) == Approx(-found->shorter));
  std::vector<Vec2> parabola;
  for (int i = -20; i <= 20; ++i) parabola.emplace_back(i, 0.05 * i * i + 0.1 * random.normal());
  const auto forced = fitted_ellipse(parabola);
  REQUIRE(forced);
  CHECK(forced->shorter > 0);
}

TEST_CASE("ellipse fit: bad_points, too few, in a line or in a place, have none") {
  CHECK(!fitted_ellipse(on_ellipse(10, 6, 0, {0, 0}, 0, 5, 5)));
  CHECK(!fitted_ellipse(std::vector<Vec2>(10, Vec2(3, 3))));
  std::vector<Vec2> line;
  for (int i = 0; i < 20; ++i) line.emplace_back(i, 3 * i + 1);
  CHECK(!fitted_ellipse(line));
}
