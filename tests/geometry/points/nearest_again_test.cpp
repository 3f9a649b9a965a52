#include "geometry/points/nearest_again.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"
#include "geometry/points/nearest_map.h"
#include "testing/moving_queries.h"

using namespace partscribe::geometry;
using namespace partscribe::testing;

namespace {

/// On a bent sheet; some of them twice.
std::vector<Vec3> sheet(std::size_t count) {
  Random random(3);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = random.uniform(-2, 2), y = random.uniform(-1, 1);
    points.emplace_back(x, y, 0.3 * x * x);
    if (i % 9 == 4) points.push_back(points.back());
  }
  return points;
}

}  // namespace

TEST_CASE("nearest again: answers stay those of the tree while queries move, within any limit") {
  const auto points = sheet(700);
  const KdTree tree(points);
  constexpr std::size_t queries = 200;
  NearestAgain again(tree, points, queries);
  Random random(5);
  std::vector<Vec3> places;
  for (std::size_t k = 0; k < queries; ++k)
    places.emplace_back(random.uniform(-3, 3), random.uniform(-2, 2), random.uniform(-1, 2));
  answers_stay_those_of(tree, again, std::move(places), 0.3, 1.5, random);
}

TEST_CASE("nearest map: what it says is hardly farther than the nearest point, inside and outside its box") {
  const auto points = sheet(700);
  const KdTree tree(points);
  const NearestMap map(points, 0.05);
  Random random(6);
  for (int k = 0; k < 2000; ++k) {
    const Vec3 p(random.uniform(-4, 4), random.uniform(-3, 3), random.uniform(-2, 3));
    const double nearest = std::sqrt(tree.nearest_one(p).sq_distance),
                 found = (points[map.near(p.x(), p.y(), p.z())] - p).norm();
    const bool inside = std::abs(p.x()) < 2 && std::abs(p.y()) < 1 && p.z() > 0 && p.z() < 1.2;
    CHECK(found <= (inside ? nearest + 3 * map.cell() : 1.5 * nearest + 3 * map.cell()));
  }
  CHECK(NearestMap({Vec3(1, 2, 3)}, 0.1).near(9, 9, 9) == 0);
}
