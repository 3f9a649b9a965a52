/// Steps of turned parts that few points show, among outliers.
#include "fit/propose/sparse_step.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"

namespace partscribe::testing {

using namespace fit;

namespace {

constexpr double noise = 0.1, top = 30;

/// Outliers strewn evenly through a cylinder about the axis, from 10 below the part's top to 30 beyond it.
std::vector<Vec2> outliers(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec2> places;
  for (std::size_t i = 0; i < count; ++i)
    places.emplace_back(25 * std::sqrt(random.uniform()), top + random.uniform(-10, 30));
  return places;
}

void add_wall(std::vector<Vec2>& places, std::size_t count, double radius, double from, double to, std::uint64_t seed) {
  Random random(seed);
  for (std::size_t i = 0; i < count; ++i)
    places.emplace_back(radius + noise * random.normal(), random.uniform(from, to));
}

}  // namespace

TEST_CASE("sparse step: forty points on a wall among two hundred outliers are a step, up or down") {
  for (const double sign : {1.0, -1.0}) {
    std::vector<Vec2> places = outliers(200, 3);
    add_wall(places, 40, 9, top, top + 14, 5);
    for (Vec2& p : places) p.y() *= sign;
    const auto step = step_beyond(places, sign * top, sign, noise, 20);
    REQUIRE(step);
    CHECK(step->radius == Approx(9).margin(0.1));
    CHECK(sign * step->end == Approx(top + 14).margin(1.5));
    CHECK(step->points > 32);
  }
}

TEST_CASE("sparse step: outliers alone make none") {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    INFO(seed);
    CHECK_FALSE(step_beyond(outliers(400, seed), top, 1, noise, 8));
  }
}

TEST_CASE("sparse step: too few points, or a wall beside the part, are none") {
  std::vector<Vec2> places = outliers(100, 3);
  add_wall(places, 15, 9, top, top + 14, 5);
  CHECK_FALSE(step_beyond(places, top, 1, noise, 20));
  places = outliers(100, 3);
  add_wall(places, 40, 9, top - 10, top, 5);
  CHECK_FALSE(step_beyond(places, top, 1, noise, 8));
  CHECK_FALSE(step_beyond({}, top, 1, noise, 20));
}

}  // namespace partscribe::testing
