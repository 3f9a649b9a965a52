/// Faces of a sketch are called as the parameters that set them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "core/number.h"
#include "fit/sketch/sketch_builder.h"
#include "model/sketch.h"

using namespace partscribe::fit;

namespace {

ProfileSegment line(const Vec2& start, const Vec2& end) {
  ProfileSegment s;
  s.start = start, s.end = end, s.point = 0.5 * (start + end), s.direction = (end - start).normalized(), s.nodes = 20,
  s.points = 400;
  return s;
}

LoopPieces outline(const std::vector<Vec2>& corners) {
  LoopPieces loop;
  loop.name = "outline";
  for (std::size_t i = 0; i < corners.size(); ++i)
    loop.segments.push_back(line(corners[i], corners[(i + 1) % corners.size()]));
  return loop;
}

LoopPieces hole(const std::string& name, const Vec2& center, double radius) {
  ProfileSegment s;
  s.arc = true, s.center = center, s.radius = radius, s.sweep = -2 * pi, s.nodes = 40, s.points = 800;
  s.start = s.end = center + Vec2(radius, 0);
  LoopPieces loop;
  loop.name = name, loop.segments = {s};
  return loop;
}

std::set<std::string> names_of(const BuiltSketch& built) {
  std::set<std::string> names;
  for (const auto& p : built.parameters) names.insert(p.name);
  return names;
}

/// Roles of the straight edges of the outline.
std::set<std::string> edges_of(const BuiltSketch& built) {
  std::set<std::string> edges;
  for (const auto& element : built.sketch.loops.front().elements)
    std::visit([&](const auto& e) { edges.insert(e.edge); }, element);
  return edges;
}

}  // namespace

TEST_CASE("sketch names: a parameter with a number is of the hole with that number") {
  std::vector<LoopPieces> loops = {outline({{0, 0}, {80, 0}, {80, 40}, {0, 40}}), hole("hole 1", {15, 20}, 6),
                                   hole("hole 2", {40, 20}, 6), hole("hole 3", {65, 30}, 4)};
  const auto names = names_of(build_sketch(loops, {.tolerance = 0.1}));
  // The third hole is the only one with a second radius and a second height.
  CHECK(names.count("hole_3_radius") == 1);
  CHECK(names.count("hole_3_y") == 1);
  CHECK(names.count("hole_2_radius") == 0);
  CHECK(names.count("hole_2_y") == 0);
}

TEST_CASE("sketch names: a chamfered edge is called as its size, a slope without one is a slope") {
  const auto built = build_sketch({outline({{0, 0}, {60, 0}, {60, 36}, {56, 40}, {0, 40}})}, {.tolerance = 0.1});
  CHECK(names_of(built).count("chamfer") == 1);
  CHECK(edges_of(built).count("chamfer") == 1);
  const auto unequal = build_sketch({outline({{0, 0}, {60, 0}, {60, 37}, {54, 40}, {0, 40}})}, {.tolerance = 0.1});
  CHECK(names_of(unequal).count("taper_width") == 1);
  CHECK(edges_of(unequal).count("taper") == 1);
  const auto triangle = build_sketch({outline({{0, 0}, {60, 0}, {30, 40}})}, {.tolerance = 0.1});
  CHECK(edges_of(triangle).count("slope") == 1);
}

TEST_CASE("sketch names: the legs of an angle have a thickness each, wherever its corner lies") {
  for (const bool far : {false, true}) {
    std::vector<Vec2> corners = {{0, 0}, {90, 0}, {90, 12}, {10, 12}, {10, 40}, {0, 40}};
    if (far)
      for (Vec2& c : corners) c = Vec2(90, 40) - c;
    const auto built = build_sketch({outline(corners)}, {.tolerance = 0.1});
    CHECK(names_of(built) == std::set<std::string>{"length", "width", "leg_thickness", "leg_2_thickness"});
    Values values;
    for (const auto& p : built.parameters) values[p.name] = p.value;
    CHECK(values["leg_thickness"] + values["leg_2_thickness"] == Approx(22));
    const auto box =
        flat_box(outline_of(std::get<ExtrudeOf<double>>(evaluate(Extrude{built.sketch, 1}, values)).sketch));
    CHECK(box.size().x() == Approx(90));
    CHECK(box.size().y() == Approx(40));
  }
}
