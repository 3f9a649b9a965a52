/// Holes that were found in a scan, cut into a body: patterns, shared sizes, and what the body's own numbers say.
#include "fit/propose/drill.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "fit/refine/refine.h"
#include "fit/sketch/length_parameter.h"
#include "model/check.h"
#include "model/distance/distance.h"

using namespace partscribe::fit;

namespace {

/// A block of 80 x 50 x 12 with a corner on the origin of its frame, turned and moved in the scan.
Candidate block() {
  Candidate c;
  c.procedure = "box", c.object_name = "block";
  c.shape = Box{Expr::of("length"), Expr::of("width"), Expr::of("height")};
  c.parameters = {length_parameter("length", 80, ""), length_parameter("width", 50, ""),
                  length_parameter("height", 12, "")};
  c.scan_from_part = {rotation_of(Vec3(0.3, -0.2, 0.5)), Vec3(5, -7, 11)};
  return c;
}

Candidate disc() {
  Candidate c;
  c.procedure = "cylinder", c.object_name = "rod";
  c.shape = Cylinder{Expr::of("radius"), Expr::of("height")};
  c.parameters = {length_parameter("radius", 40, ""), length_parameter("height", 10, "")};
  c.scan_from_part = {rotation_of(Vec3(-0.4, 0.1, 0.2)), Vec3(1, 2, 3)};
  return c;
}

/// A hole that opens at a place of the body's frame.
DrilledHole hole_at(const Candidate& body, const Vec3& mouth, const Vec3& out, double diameter, double depth,
                    bool through = true) {
  DrilledHole hole;
  hole.form.diameter = diameter, hole.form.depth = depth, hole.form.through = through;
  hole.mouth = body.scan_from_part * mouth, hole.out = body.scan_from_part.rotation * out;
  hole.point = hole.mouth - 0.5 * depth * hole.out;
  hole.sigma = 0.002;
  return hole;
}

std::vector<std::string> names_of(const Candidate& c) {
  std::vector<std::string> names;
  for (const Parameter& p : c.parameters) names.push_back(p.name);
  return names;
}

double value_of(const Candidate& c, const std::string& name) {
  const auto p = std::ranges::find(c.parameters, name, &Parameter::name);
  return p == c.parameters.end() ? NAN : p->value;
}

/// Signed distance of a place in the body's frame from the drilled part.
double distance_at(const Candidate& body, const Candidate& part, const Vec3& place) {
  return ModelDistance(bare_model(part))(part.scan_from_part.inverse() * (body.scan_from_part * place)).distance;
}

constexpr DrillOptions options{0.1, 0.02, 0.5};

}  // namespace

TEST_CASE("drill: holes at the corners of a plate are rows with pitches about its middle") {
  const Candidate body = block();
  std::vector<DrilledHole> holes;
  for (const double x : {10.0, 70.0})
    for (const double y : {8.0, 42.0}) holes.push_back(hole_at(body, {x, y, 12}, Vec3::UnitZ(), 6, 12));
  holes.push_back(hole_at(body, {40, 25, 0}, -Vec3::UnitZ(), 20, 12));  // seen from below
  const auto part = with_holes(body, holes, options);
  REQUIRE(part);
  CHECK(names_of(*part) ==
        std::vector<std::string>{"length", "width", "thickness", "hole_d", "pitch_x", "pitch_y", "bore_d"});
  CHECK(value_of(*part, "pitch_x") == Approx(60));
  CHECK(value_of(*part, "pitch_y") == Approx(34));
  CHECK(value_of(*part, "bore_d") == Approx(20));
  CHECK(std::holds_alternative<CheckedModel>(check(bare_model(*part))));
  CHECK(distance_at(body, *part, {13, 8, 6}) == Approx(0).margin(1e-9));       // on a hole's wall
  CHECK(distance_at(body, *part, {70, 42, 6}) == Approx(3).margin(1e-9));      // on its axis
  CHECK(distance_at(body, *part, {40, 25, 11.9}) == Approx(10).margin(1e-3));  // in the bore
  CHECK(distance_at(body, *part, {0, 20, 6}) == Approx(0).margin(1e-9));       // on an outer wall
  CHECK(distance_at(body, *part, {25, 25, 11}) == Approx(-1).margin(1e-9));    // below the face
}

TEST_CASE("drill: the depth of a through hole follows the thickness of its plate") {
  const Candidate body = block();
  auto part = with_holes(body, {hole_at(body, {20, 10, 12}, Vec3::UnitZ(), 6, 12)}, options);
  REQUIRE(part);
  for (Parameter& p : part->parameters)
    if (p.name == "thickness") p.value = 30;
  CHECK(distance_at(body, *part, {20, 10, 29}) == Approx(3).margin(1e-9));
  CHECK(distance_at(body, *part, {20, 10, 1}) == Approx(3).margin(1e-9));
}

TEST_CASE("drill: equally spaced holes of a disc are a bolt circle, the first of them on x") {
  const Candidate body = disc();
  std::vector<DrilledHole> holes;
  for (int k = 0; k < 5; ++k) {
    const double turn = 0.3 + 2 * M_PI * k / 5;
    holes.push_back(hole_at(body, {30 * std::cos(turn), 30 * std::sin(turn), 10}, Vec3::UnitZ(), 6, 10));
    holes.back().form.sink_diameter = 11, holes.back().form.sink_angle = M_PI / 2;
  }
  const auto part = with_holes(body, holes, options);
  REQUIRE(part);
  CHECK(names_of(*part) == std::vector<std::string>{"radius", "height", "screw_hole_d", "sink_d", "sink_angle",
                                                    "bolt_circle_d", "screw_holes"});
  CHECK(value_of(*part, "bolt_circle_d") == Approx(60));
  CHECK(value_of(*part, "screw_holes") == 5);
  CHECK(std::holds_alternative<CheckedModel>(check(bare_model(*part))));
  for (const DrilledHole& h : holes)
    CHECK(ModelDistance(bare_model(*part))(part->scan_from_part.inverse() * (h.mouth - 8 * h.out)).distance ==
          Approx(3).margin(1e-6));
}

TEST_CASE("drill: four holes in a square are rows of a plate and a bolt circle of a disc") {
  const auto square_in = [](const Candidate& body, const Vec3& middle) {
    std::vector<DrilledHole> holes;
    for (const double x : {-15.0, 15.0})
      for (const double y : {-15.0, 15.0}) holes.push_back(hole_at(body, middle + Vec3(x, y, 0), Vec3::UnitZ(), 5, 10));
    return with_holes(body, holes, options);
  };
  const auto plate = square_in(block(), {40, 25, 12}), round = square_in(disc(), {0, 0, 10});
  REQUIRE((plate && round));
  CHECK(value_of(*plate, "pitch_x") == Approx(30));
  CHECK(value_of(*plate, "pitch_y") == Approx(30));
  CHECK(value_of(*round, "bolt_circle_d") == Approx(30 * std::sqrt(2)));
}

TEST_CASE("drill: holes with spacings of their own keep their places") {
  const Candidate body = block();
  const auto part =
      with_holes(body,
                 {hole_at(body, {10, 8, 12}, Vec3::UnitZ(), 6, 12), hole_at(body, {33, 21, 12}, Vec3::UnitZ(), 6, 12),
                  hole_at(body, {61, 17, 12}, Vec3::UnitZ(), 6, 12)},
                 options);
  REQUIRE(part);
  CHECK(names_of(*part) == std::vector<std::string>{"length", "width", "thickness", "hole_d", "hole_x", "hole_y",
                                                    "hole_2_x", "hole_2_y", "hole_3_x", "hole_3_y"});
  CHECK(value_of(*part, "hole_2_x") == Approx(33 - 40));
  CHECK(value_of(*part, "hole_2_y") == Approx(21 - 25));
}

TEST_CASE("drill: a blind hole keeps its depth where its floor was not seen") {
  const Candidate body = block();
  DrilledHole seen = hole_at(body, {20, 0, 6}, -Vec3::UnitY(), 5, 15, false), unseen = seen;
  unseen.floor_seen = false;
  const auto told = with_holes(body, {seen}, options), open = with_holes(body, {unseen}, options);
  REQUIRE((told && open));
  CHECK(value_of(*told, "hole_depth") == Approx(15));
  CHECK(told->held.empty());
  REQUIRE(open->held.size() == 1);
  CHECK(open->held[0].name == "hole_depth");
  // Across the plate and in the middle of its thickness.
  CHECK(names_of(*told) == std::vector<std::string>{"length", "width", "thickness", "hole_depth", "hole_d", "hole_x"});
  CHECK(distance_at(body, *told, {20, 14, 6}) == Approx(1).margin(1e-9));
  CHECK(distance_at(body, *told, {20, 16, 6}) == Approx(-1).margin(1e-9));
}

TEST_CASE("drill: plain holes along an extrusion are loops of its sketch") {
  Candidate bar = block();
  Loop outline;
  outline.name = "outline";
  outline.elements = {SketchPoint{0, 0, ""}, SketchPoint{80, 0, ""}, SketchPoint{60, 50, ""}};
  bar.shape = Extrude{{{outline}}, Expr::of("height")};
  bar.parameters = {length_parameter("height", 12, "")};
  const DrilledHole through = hole_at(bar, {50, 20, 12}, Vec3::UnitZ(), 6, 12),
                    blind = hole_at(bar, {30, 8, 12}, Vec3::UnitZ(), 6, 5, false);
  CHECK(in_sketch(bar, {through}));
  CHECK_FALSE(in_sketch(bar, {through, blind}));
  CHECK_FALSE(in_sketch(block(), {through}));
}

TEST_CASE(
    "drill: a hole of which little was seen may lean by as much as its axis is unknown, and stands where it was seen") {
  const Candidate body = block();
  DrilledHole leaning = hole_at(body, {20, 10, 12}, Vec3::UnitZ(), 6, 12);
  leaning.out = body.scan_from_part.rotation * Vec3(0.02, 0, 1).normalized();
  leaning.mouth = leaning.point + 6 * leaning.out;
  CHECK_FALSE(with_holes(body, {leaning}, options));
  leaning.sigma_axis = 0.01;
  const auto part = with_holes(body, {leaning}, options);
  REQUIRE(part);
  CHECK(ModelDistance(bare_model(*part))(part->scan_from_part.inverse() * leaning.point).distance ==
        Approx(3).margin(1e-6));
}

TEST_CASE("drill: holes aslant and holes beside the body are none of it") {
  const Candidate body = block();
  CHECK_FALSE(with_holes(body, {hole_at(body, {20, 10, 12}, Vec3(0.2, 0, 1).normalized(), 6, 12)}, options));
  CHECK_FALSE(with_holes(body, {hole_at(body, {20, 90, 12}, Vec3::UnitZ(), 6, 12)}, options));
}
