#include "fit/sketch/outline_cells.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"

using namespace partscribe::fit;

namespace {

constexpr double end_radius = 12, spacing = 40, hole_radius = 5, noise = 0.1;

/// A tie bar along x: round ends about (0, 0) and (spacing, 0), a hole in each.
bool inside(const Vec2& p) {
  const double x = std::clamp(p.x(), 0.0, spacing);
  const double to_hole = std::min(p.norm(), (p - Vec2(spacing, 0)).norm());
  return (p - Vec2(x, 0)).norm() < end_radius && to_hole > hole_radius;
}

/// The upper wall, the lower one if asked for, both ends, and of each hole the part with x below its centre.
OutlineData tie_bar(bool with_lower_wall) {
  OutlineData data;
  data.band = 0.3, data.spacing = 0.8;
  Random random(5);
  const auto wall = [&](const Vec2& p, const Vec2& n) { data.walls.push_back({p + noise * random.normal() * n, n}); };
  for (int i = 0; i < 300; ++i) {
    wall({random.uniform(0, spacing), end_radius}, {0, 1});
    if (with_lower_wall) wall({random.uniform(0, spacing), -end_radius}, {0, -1});
    const double a = random.uniform(0.5 * pi, 1.5 * pi);
    const Vec2 out(std::cos(a), std::sin(a));
    wall(end_radius * out, out);
    wall(Vec2(spacing, 0) + end_radius * Vec2(-out.x(), out.y()), {-out.x(), out.y()});
    wall(hole_radius * out, out), wall(Vec2(spacing, 0) + hole_radius * out, out);
  }
  while (data.ends.size() < 2500) {
    const Vec2 p(random.uniform(-end_radius, spacing + end_radius), random.uniform(-end_radius, end_radius));
    if (inside(p)) data.ends.push_back(p);
  }
  return data;
}

double radius_of_arc(const LoopPieces& loop) {
  for (const auto& s : loop.segments)
    if (s.arc) return s.radius;
  return 0;
}

}  // namespace

TEST_CASE("outline by cells: a plate with holes of which half the wall was seen") {
  const auto loops = outline_by_cells(tie_bar(true));
  REQUIRE(loops.size() == 3);
  CHECK(radius_of_arc(loops[0]) == Approx(end_radius).margin(0.1));
  CHECK(radius_of_arc(loops[1]) == Approx(hole_radius).margin(0.1));
  CHECK(radius_of_arc(loops[2]) == Approx(hole_radius).margin(0.1));
}

TEST_CASE("outline by cells: a wall that nobody saw is put where the end face ends") {
  const auto loops = outline_by_cells(tie_bar(false));
  REQUIRE(loops.size() == 3);
  double lowest = 0;
  for (const auto& s : loops[0].segments) lowest = std::min({lowest, s.start.y(), s.end.y()});
  CHECK(lowest == Approx(-end_radius).margin(0.5));
}

TEST_CASE("outline by cells: end faces without walls have no outline") {
  OutlineData data = tie_bar(true);
  data.walls.clear();
  CHECK(outline_by_cells(data).empty());
}
