// Sketches are dimensioned as a designer would: sizes, spacings, symmetry about the origin.
#include "fit/sketch/sketch_layout.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>

#include "core/number.h"
#include "fit/sketch/sketch_builder.h"

using namespace partscribe::fit;

namespace {

/// Counter-clockwise from the lower left corner; clockwise if it is a hole.
LoopPieces rectangle(const Vec2& low, const Vec2& high, bool hole, std::string name) {
  std::vector<Vec2> corners = {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
  if (hole) std::reverse(corners.begin(), corners.end());
  LoopPieces loop;
  loop.name = std::move(name);
  for (std::size_t k = 0; k < 4; ++k) {
    ProfileSegment s;
    s.start = corners[k], s.end = corners[(k + 1) % 4];
    s.point = (s.start + s.end) / 2, s.direction = (s.end - s.start).normalized();
    loop.segments.push_back(s);
  }
  return loop;
}

LoopPieces circle(const Vec2& center, double radius, bool hole, std::string name) {
  ProfileSegment s;
  s.arc = true, s.center = center, s.radius = radius, s.sweep = hole ? -2 * pi : 2 * pi;
  s.start = s.end = center + Vec2(radius, 0);
  return {{s}, false, std::move(name)};
}

std::map<std::string, double> sizes_of(const BuiltSketch& sketch) {
  std::map<std::string, double> values;
  for (const auto& p : sketch.parameters) values[p.name] = snapped(p.value, 1e-9);
  return values;
}

using Sizes = std::map<std::string, double>;

}  // namespace

TEST_CASE("sketch: a plate with holes evenly about its middle has seven sizes, none of them a coordinate") {
  std::vector<LoopPieces> loops = {rectangle({10, 20}, {90, 70}, false, "outline"),
                                   circle({50, 45}, 11, true, "hole 1")};
  for (const double x : {20, 80})
    for (const double y : {30, 60}) loops.push_back(circle({x, y}, 3, true, "hole"));
  const BuiltSketch sketch = build_sketch(loops, {.tolerance = 0.1});
  CHECK(sketch.origin == Vec2(50, 45));
  CHECK(
      sizes_of(sketch) ==
      Sizes{
          {"length", 80}, {"width", 50}, {"hole_radius", 11}, {"hole_2_radius", 3}, {"pitch_x", 60}, {"pitch_y", 30}});
}

TEST_CASE("sketch: an even row of holes has one pitch") {
  std::vector<LoopPieces> loops = {rectangle({0, 0}, {100, 20}, false, "outline")};
  for (const double x : {14, 38, 62, 86}) loops.push_back(circle({x, 10}, 4, true, "hole"));
  const BuiltSketch sketch = build_sketch(loops, {.tolerance = 0.1});
  CHECK(sizes_of(sketch) == Sizes{{"length", 100}, {"width", 20}, {"hole_radius", 4}, {"pitch_x", 24}});
}

TEST_CASE("sketch: holes off the middle are placed from the corner, and from one another") {
  const BuiltSketch sketch = build_sketch({rectangle({0, 0}, {100, 40}, false, "outline"),
                                           circle({12, 10}, 3, true, "hole 1"), circle({37, 10}, 3, true, "hole 2")},
                                          {.tolerance = 0.1});
  CHECK(sketch.origin == Vec2(0, 0));
  CHECK(sizes_of(sketch) ==
        Sizes{{"length", 100}, {"width", 40}, {"hole_radius", 3}, {"hole_x", 12}, {"pitch_x", 25}, {"hole_y", 10}});
}

TEST_CASE("sketch: a round outline has its origin in its centre, whatever its hole, and a square hole one size") {
  const BuiltSketch sketch = build_sketch(
      {circle({7, -3}, 10, false, "outline"), rectangle({4, -6}, {10, 0}, true, "hole")}, {.tolerance = 0.1});
  CHECK(sketch.origin == Vec2(7, -3));
  CHECK(sizes_of(sketch) == Sizes{{"disc_radius", 10}, {"hole_side", 6}});
  const BuiltSketch off = build_sketch({circle({0, 0}, 10, false, "outline"), rectangle({1, -2}, {7, 2}, true, "hole")},
                                       {.tolerance = 0.1});
  CHECK(sizes_of(off) == Sizes{{"disc_radius", 10}, {"hole_length", 6}, {"hole_width", 4}, {"hole_x", 4}});
}

TEST_CASE("sketch: a row of square holes shares its levels and its size") {
  std::vector<LoopPieces> loops = {rectangle({0, 0}, {60, 20}, false, "outline")};
  for (const double x : {10, 40}) loops.push_back(rectangle({x, 5}, {x + 10, 15}, true, "hole"));
  const BuiltSketch sketch = build_sketch(loops, {.tolerance = 0.1});
  CHECK(sizes_of(sketch) == Sizes{{"length", 60}, {"width", 20}, {"hole_side", 10}, {"pitch_x", 30}});
}

TEST_CASE("sketch: a plate without holes keeps its corner on the origin") {
  const BuiltSketch sketch = build_sketch({rectangle({10, 20}, {90, 70}, false, "outline")}, {.tolerance = 0.1});
  CHECK(sketch.origin == Vec2(10, 20));
  CHECK(sizes_of(sketch) == Sizes{{"length", 80}, {"width", 50}});
}
