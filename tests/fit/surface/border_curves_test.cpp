#include "fit/surface/border_curves.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"

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
