// Profiles: chains find their way around corners, and the fewest pieces explain them.
#include "fit/sketch/profile.h"

#include <catch2/catch.hpp>

#include "core/number.h"
#include "core/random.h"

using namespace partscribe::fit;

namespace {

/// Points on a polyline with noise, and its normals.
std::vector<PlanePoint> along(const std::vector<Vec2>& corners, bool closed, double noise, std::uint64_t seed) {
  Random random(seed);
  std::vector<PlanePoint> points;
  for (std::size_t i = 0; i + (closed ? 0 : 1) < corners.size(); ++i) {
    const Vec2 a = corners[i], b = corners[(i + 1) % corners.size()];
    const Vec2 t = (b - a).normalized(), n(t.y(), -t.x());
    const int count = static_cast<int>((b - a).norm() * 60);
    for (int k = 0; k < count; ++k)
      points.push_back(
          {a + (b - a) * random.uniform() + n * noise * random.normal(), random.uniform() < 0.5 ? n : Vec2(-n)});
  }
  return points;
}

}  // namespace

TEST_CASE("profile: a closed outline of straight edges has as many pieces as edges") {
  const std::vector<Vec2> corners = {{0, 0}, {40, 0}, {40, 15}, {25, 15}, {25, 30}, {0, 30}};
  const auto chains = chains_of(along(corners, true, 0.02, 3), {.cell = 0.4, .noise = 0.02});
  REQUIRE(chains.size() == 1);
  CHECK(chains[0].closed);
  const auto segments = segments_of(chains[0], {.floor = 0.02, .size = 50});
  CHECK(segments.size() == 6);
  for (const auto& s : segments) CHECK_FALSE(s.arc);
}

TEST_CASE("profile: a circle is one arc of the true radius") {
  Random random(4);
  std::vector<PlanePoint> points;
  for (int i = 0; i < 4000; ++i) {
    const double a = random.uniform(0, 2 * pi);
    const Vec2 n(std::cos(a), std::sin(a));
    points.push_back({Vec2(5, 6) + n * (12 + 0.02 * random.normal()), n});
  }
  const auto chains = chains_of(points, {.cell = 0.4, .noise = 0.02});
  REQUIRE(chains.size() == 1);
  const auto segments = segments_of(chains[0], {.floor = 0.02, .size = 30});
  REQUIRE(segments.size() == 1);
  CHECK(segments[0].arc);
  CHECK(segments[0].radius == Approx(12).margin(0.01));
  CHECK((segments[0].center - Vec2(5, 6)).norm() < 0.01);
}

TEST_CASE("profile: line, tangent arc, line come out as three pieces") {
  Random random(9);
  std::vector<PlanePoint> points = along({{0, 0}, {20, 0}}, false, 0.02, 5);
  for (const auto& p : along({{26, 6}, {26, 30}}, false, 0.02, 6)) points.push_back(p);
  for (int i = 0; i < 600; ++i) {
    const double a = random.uniform(-pi / 2, 0);
    const Vec2 n(std::cos(a), std::sin(a));
    points.push_back({Vec2(20, 6) + n * (6 + 0.02 * random.normal()), n});
  }
  const auto chains = chains_of(points, {.cell = 0.4, .noise = 0.02});
  REQUIRE(chains.size() == 1);
  const auto segments = segments_of(chains[0], {.floor = 0.02, .size = 40});
  REQUIRE(segments.size() == 3);
  CHECK(segments[1].arc);
  CHECK(segments[1].radius == Approx(6).margin(0.1));
}

TEST_CASE("profile: missing data leave a gap that is bridged and told") {
  auto points = along({{0, 0}, {40, 0}, {40, 30}, {0, 30}}, true, 0.01, 8);
  points.erase(std::remove_if(points.begin(), points.end(),
                              [](const PlanePoint& p) {
                                return p.position.y() < 1 && p.position.x() > 10 && p.position.x() < 16;
                              }),
               points.end());
  const auto chains = chains_of(points, {.cell = 0.4, .noise = 0.01});
  REQUIRE(chains.size() == 1);
  CHECK(chains[0].closed);
  REQUIRE(chains[0].gaps.size() == 1);
  CHECK(chains[0].gaps[0] == Approx(6).margin(1));
}

TEST_CASE("profile: a wavy edge is one spline, not a chain of arcs") {
  Random random(12);
  std::vector<PlanePoint> points;
  for (int i = 0; i < 9000; ++i) {
    const double x = random.uniform(0, 60), y = 4 * std::sin(x / 6) + 0.02 * x * x / 6,
                 slope = 4 / 6.0 * std::cos(x / 6) + 0.04 * x / 6;
    const Vec2 n = Vec2(-slope, 1).normalized();
    points.push_back({Vec2(x, y) + n * 0.01 * random.normal(), n});
  }
  const auto chains = chains_of(points, {.cell = 0.3, .noise = 0.01});
  REQUIRE(chains.size() == 1);
  ProfileOptions options{.floor = 0.01, .size = 60};
  const auto arcs = segments_of(chains[0], options);
  CHECK(arcs.size() >= 4);
  options.spline = 0.02;
  const auto splines = segments_of(chains[0], options);
  REQUIRE(splines.size() == 1);
  CHECK(splines[0].spline);
  CHECK(splines[0].curve.points.size() < 30);
  double worst = 0;
  for (double x = 2; x < 58; x += 0.5) {
    const Vec2 truth(x, 4 * std::sin(x / 6) + 0.02 * x * x / 6);
    double nearest = 1e9;
    for (double u = 0; u <= 1; u += 0.0005) nearest = std::min(nearest, (splines[0].curve.at(u) - truth).norm());
    worst = std::max(worst, nearest);
  }
  CHECK(worst < 0.05);
}
