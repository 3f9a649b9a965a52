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
