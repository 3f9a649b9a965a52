#include "fit/surface/border_curves.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "fit/surface/curve_crossings.h"

using namespace partscribe::core;
using namespace partscribe::geometry;
using namespace partscribe::fit;

namespace {

double farthest(const std::vector<Vec2>& places, const std::vector<NurbsCurve<2>>& curves) {
  std::vector<Vec2> line;
  for (const auto& c : curves)
    for (int i = 0; i < 400; ++i) line.push_back(c.at(c.t.low() + (c.t.high() - c.t.low()) * i / 400));
  double worst = 0;
  for (const Vec2& p : places) {
    double least = 1e300;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const Vec2 &a = line[i], d = line[(i + 1) % line.size()] - a;
      const double t = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-30), 0.0, 1.0);
      least = std::min(least, (a + t * d - p).norm());
    }
    worst = std::max(worst, least);
  }
  return worst;
}

void closes(const std::vector<NurbsCurve<2>>& curves) {
  for (std::size_t i = 0; i < curves.size(); ++i)
    CHECK(curves[i].points.back() == curves[(i + 1) % curves.size()].points.front());
}

}  // namespace

TEST_CASE("border curves: a rectangle is four lines, wherever its list of places begins") {
  std::vector<Vec2> places;
  for (int i = 0; i < 40; ++i) places.emplace_back(i, 0);
  for (int i = 0; i < 25; ++i) places.emplace_back(40, i);
  for (int i = 40; i > 0; --i) places.emplace_back(i, 25);
  for (int i = 25; i > 0; --i) places.emplace_back(0, i);
  for (const std::size_t start : {0u, 17u, 40u}) {
    std::vector<Vec2> turned(places.begin() + long(start), places.end());
    turned.insert(turned.end(), places.begin(), places.begin() + long(start));
    const auto curves = border_curves(turned, 0.2);
    CHECK(curves.size() == 4);
    for (const auto& c : curves) CHECK(c.t.degree == 1);
    CHECK(farthest(places, curves) < 1e-9);
    closes(curves);
  }
}

TEST_CASE("border curves: a circle is one closed curve of few control points, and so is a zigzag along it") {
  for (const double noise : {0.0, 0.05}) {
    Random random(3);
    std::vector<Vec2> places;
    for (int i = 0; i < 300; ++i) {
      const double angle = 2 * pi * i / 300, radius = 20 + noise * random.normal();
      places.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    }
    const auto curves = border_curves(places, 0.25);
    REQUIRE(curves.size() == 1);
    CHECK(curves[0].points.size() < 14);
    CHECK(farthest(places, curves) < 0.25);
    closes(curves);
  }
}

TEST_CASE("border curves: half a disc is a line and a curve between two corners") {
  std::vector<Vec2> places;
  for (int i = 0; i <= 120; ++i) places.emplace_back(15 * std::cos(pi * i / 120), 15 * std::sin(pi * i / 120));
  for (int i = 1; i < 60; ++i) places.emplace_back(-15 + 0.5 * i, 0);
  const auto curves = border_curves(places, 0.1);
  REQUIRE(curves.size() == 2);
  CHECK(curves[0].t.degree + curves[1].t.degree == 4);
  CHECK(farthest(places, curves) < 0.1);
  closes(curves);
}

TEST_CASE("border curves: held in a box, a curve stays where it is while its control points come inside") {
  // A circle of radius 10 in four spans: its control points lie up to 1.3 mm outside of it.
  std::vector<Vec2> places;
  for (int i = 0; i < 200; ++i) places.emplace_back(10 * std::cos(2 * pi * i / 200), 10 * std::sin(2 * pi * i / 200));
  const auto curves = border_curves(places, 0.1);
  REQUIRE(curves.size() == 1);
  const Vec2 high = Vec2::Constant(10.15), low = -high;
  const auto leaves = [&](const NurbsCurve<2>& curve) {
    double most = 0;
    for (const Vec2& p : curve.points) most = std::max(most, (p.cwiseMax(low).cwiseMin(high) - p).norm());
    return most;
  };
  const auto moved = [&](const NurbsCurve<2>& curve) {
    double most = 0;
    for (int i = 0; i <= 1000; ++i) most = std::max(most, (curve.at(i / 1000.0) - curves[0].at(i / 1000.0)).norm());
    return most;
  };
  REQUIRE(leaves(curves[0]) > 0.3);
  const auto held = held_in(curves[0], low, high, 0.01);
  CHECK(leaves(held) == 0);
  CHECK(moved(held) < 0.01);
  CHECK(held.points.size() < 4 * curves[0].points.size());
  // Control points that are merely moved inside take the curve with them.
  NurbsCurve<2> pressed = curves[0];
  for (Vec2& p : pressed.points) p = p.cwiseMax(low).cwiseMin(high);
  CHECK(moved(pressed) > 0.1);
  // Where a curve leaves the box itself it follows the border.
  const auto cut = held_in(curves[0], {-20, -20}, {8, 20}, 0.01);
  double right = -20;
  for (int i = 0; i <= 1000; ++i) right = std::max(right, cut.at(i / 1000.0).x());
  CHECK(right == Approx(8).margin(0.02));
  CHECK(right < 8 + 1e-9);
}

TEST_CASE("border curves: none of an outline that goes to and fro crosses another or itself") {
  for (const double amplitude : {0.4, 0.8, 1.2}) {
    Random random(7);
    std::vector<Vec2> places;
    for (int i = 0; i < 240; ++i) {
      const double a = 2 * pi * i / 240, off = amplitude * (random.uniform() - 0.5),
                   along = amplitude * (random.uniform() - 0.5);
      places.emplace_back((30 + off) * std::cos(a) - along * std::sin(a),
                          (20 + off) * std::sin(a) + along * std::cos(a));
    }
    const auto curves = border_curves(places, 0.1);
    closes(curves);
    std::vector<const NurbsCurve<2>*> list;
    for (const auto& curve : curves) list.push_back(&curve);
    CHECK(crossings_of(list).empty());
    CHECK(farthest(places, curves) < 0.1 + amplitude);
  }
}
