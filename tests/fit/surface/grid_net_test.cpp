#include "fit/surface/grid_net.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"

using namespace partscribe::core;
using namespace partscribe::geometry;
using namespace partscribe::fit;

namespace {

/// A quarter of a tube with a wave on it: all three components bend.
SplineGrid waved_tube() {
  SplineGrid grid;
  for (int i = 0; i <= 60; ++i) grid.u.push_back(0.5 * i);
  for (int j = 0; j <= 40; ++j) grid.v.push_back(0.6 * j);
  for (const double u : grid.u)
    for (const double v : grid.v) {
      const double r = 20 + 0.5 * std::sin(v / 3) * std::cos(u / 4);
      grid.points.emplace_back(r * std::cos(u / 20), r * std::sin(u / 20), v);
    }
  return grid;
}

const GridKnots start = {clamped(3, {0, 5, 9, 14, 20, 25, 30}), clamped(3, {0, 4, 9, 13, 18, 24})};

}  // namespace

TEST_CASE("grid net: a knot that moves or goes changes distances as a new fit does") {
  const auto grid = waved_tube();
  GridFitOptions options;
  options.tolerance = 0.1;
  for (const std::size_t d : {0u, 1u}) {
    GridNet net(grid, options);
    net.set(start);
    const double first = net.norm().sum;
    bool moved = false;
    for (const double by : {0.3, 0.2, 0.1}) moved = moved || net.move(d, d == 0 ? 14.0 : 13.0, by);
    REQUIRE(moved);
    CHECK(net.norm().sum < first);
    REQUIRE(net.take_out(d, d == 0 ? 20.0 : 18.0, 1e9));
    CHECK(net.knots(d).count() == start[d].count() - 1);
    CHECK(net.knots(1 - d) == start[1 - d]);
    const auto updated = net.distances();
    net.look();
    REQUIRE(updated.size() == net.distances().size());
    double most = 0, off = 0;
    for (std::size_t i = 0; i < updated.size(); ++i) {
      most = std::max(most, double(std::abs(net.distances()[i])));
      off = std::max(off, double(std::abs(net.distances()[i] - updated[i])));
    }
    CHECK(off < 0.05 * most);  // normals are those before; what is nearly zero far from the knot is left out
  }
}

TEST_CASE("grid net: a knot that would leave too much stays, and a state comes back as it was") {
  const auto grid = waved_tube();
  GridNet net(grid, {});
  net.set(start);
  const auto before = net.state();
  CHECK_FALSE(net.take_out(0, 14, 0.5 * net.norm().worst));
  CHECK(net.knots() == start);
  REQUIRE(net.take_out(1, 9, 1e9));
  net.restore(before);
  CHECK(net.knots() == start);
  CHECK(net.distances() == before.off);
  CHECK(net.norm().worst == before.norm.worst);
}

TEST_CASE("grid net: what the samples do not see, all lines do") {
  auto grid = waved_tube();
  GridNet smooth(grid, {});
  smooth.set(start);
  const double before = smooth.look_at_all();
  CHECK(smooth.norm().worst * 0.1 <= before * 1.0001);
  // One point far off, between the samples.
  std::size_t line = 1;
  while (std::binary_search(smooth.samples(0).begins.begin(), smooth.samples(0).begins.end(), line)) ++line;
  grid.points[line * grid.v.size() + 20] *= 1.1;
  GridNet spoiled(grid, {});
  spoiled.set(start);
  CHECK(spoiled.look_at_all() > 1.5);
  const auto& begins = spoiled.samples(0).begins;
  CHECK_FALSE(std::binary_search(begins.begin(), begins.end(), line));
  spoiled.set(start);
  CHECK(std::binary_search(begins.begin(), begins.end(), line));
  CHECK(spoiled.norm().worst * 0.1 > 1.5);
}
