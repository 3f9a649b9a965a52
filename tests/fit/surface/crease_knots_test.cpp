#include "fit/surface/crease_knots.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"

using namespace partscribe::core;
using namespace partscribe::geometry;
using namespace partscribe::fit;

namespace {

const KnotVector across = clamped(3, {0, 10, 20});
/// Many crowd from 13 to 16 of 40.
const KnotVector crowded = clamped(3, {0, 8, 13, 14, 14.5, 15, 16, 24, 32, 40});

template <class Height>
std::optional<KnotVector> found(const Height& height, double noise, bool along_u) {
  Random random(2);
  std::vector<Vec3> points;
  std::vector<Vec2> places;
  for (int i = 0; i < 12000; ++i) {
    const double a = 40 * random.uniform(), b = 20 * random.uniform();
    places.push_back(along_u ? Vec2(a, b) : Vec2(b, a));
    points.emplace_back(places.back().x(), places.back().y(), height(a, b) + noise * random.normal());
  }
  return crease_knots({points, places, {}, noise}, along_u ? crowded : across, along_u ? across : crowded, along_u);
}

}  // namespace

TEST_CASE("crease knots: a fold takes a triple knot in its place") {
  const auto fold = [](double a, double b) { return 0.3 * std::abs(a - 14.2) + 0.01 * b * b; };
  for (const bool along_u : {true, false})
    for (const double noise : {0.0, 0.03}) {
      const auto folded = found(fold, noise, along_u);
      REQUIRE(folded);
      CHECK(folded->count() < crowded.count());
      for (const auto& [at, times] : folded->multiplicities()) {
        if (at == 0 || at == 40) continue;
        CHECK(times == (std::abs(at - 14.2) < 0.03 ? 3 : 1));
      }
      CHECK(std::any_of(folded->knots.begin() + 4, folded->knots.end() - 4,
                        [](double t) { return std::abs(t - 14.2) < 0.03; }));
    }
}

TEST_CASE("crease knots: where knots crowd for a round bend, or do not crowd, they stay") {
  const auto round = [](double a, double) { return 2 * std::tanh((a - 14.5) / 0.8); };
  CHECK_FALSE(found(round, 0, true));
  CHECK(narrow_spans({0, 10, 20, 30, 40}).empty());
  CHECK(narrow_spans(crowded.breaks()) == std::vector<std::size_t>{3, 4});
}

TEST_CASE("crease knots: the highest place of a function") {
  CHECK(highest_place([](double t) { return -(t - 2.37) * (t - 2.37); }, 0, 5, 1e-5) == Approx(2.37).margin(1e-4));
  CHECK(highest_place([](double t) { return t; }, 0, 5) == Approx(5).margin(0.01));
  CHECK(highest_place([](double t) { return -t; }, 0, 5) == Approx(0).margin(0.01));
}
