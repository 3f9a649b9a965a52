/// Chains of points find their way around corners.
#include "fit/sketch/plane_chain.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"

using namespace partscribe::fit;

TEST_CASE("plane chain: a band of noise wider than the nodes becomes one chain around a corner") {
  Random random(5);
  std::vector<PlanePoint> points;
  const double noise = 0.6, cell = 1;
  for (int i = 0; i < 1500; ++i) {
    const double s = random.uniform(0, 60), off = noise * random.normal(), turn = 0.05 * random.normal();
    const Vec2 u(std::cos(turn), std::sin(turn)), v(-u.y(), u.x());
    points.push_back(s < 30 ? PlanePoint{{s, off}, v} : PlanePoint{{30 + off, s - 30}, u});
  }
  const ChainOptions options{.cell = cell, .noise = noise};
  const auto bare = chains_of(points, options), sharp = chains_of(sharpened(points, 4 * noise), options);
  REQUIRE_FALSE(sharp.empty());
  CHECK(length_of(sharp[0]) == Approx(60).margin(4));
  CHECK(std::abs(length_of(bare[0]) - 60) > 10);
  for (const auto& node : sharp[0].nodes)
    CHECK(std::min(std::abs(node.position.y()), std::abs(node.position.x() - 30)) < noise);
}

TEST_CASE("plane chain: points all over an area are no curve, those of two walls are") {
  Random random(6);
  std::vector<PlanePoint> area, walls;
  for (int i = 0; i < 20000; ++i) {
    const double turn = random.uniform(0, 3.14);
    area.push_back({{random.uniform(0, 40), random.uniform(0, 40)}, {std::cos(turn), std::sin(turn)}});
    const double along = random.uniform(0, 80);
    walls.push_back(along < 40 ? PlanePoint{{along, 0}, {0, 1}} : PlanePoint{{80 - along, 1.5}, {0, 1}});
  }
  const ChainOptions options{.cell = 0.5, .noise = 0.02};
  const auto spread = chains_of(area, options), curve = chains_of(walls, options);
  REQUIRE_FALSE(spread.empty());
  REQUIRE_FALSE(curve.empty());
  CHECK(fills_area(spread[0], options.cell));
  CHECK_FALSE(fills_area(curve[0], options.cell));
}
