// check() lets sense through and names nonsense.
#include "model/check.h"

#include <catch2/catch.hpp>

#include "testing/models.h"

using namespace partscribe::model;
using namespace partscribe::testing;

namespace {

std::string complaints_of(Model model) {
  auto outcome = check(std::move(model));
  std::string all;
  if (const auto* c = std::get_if<Complaints>(&outcome))
    for (const auto& line : c->lines) all += line + "\n";
  return all;
}

void expect_complaint(Model model, const std::string& part) {
  const std::string all = complaints_of(std::move(model));
  INFO("complaints: " << all);
  CHECK(all.find(part) != std::string::npos);
}

}  // namespace

TEST_CASE("check: every sound model passes") {
  for (const auto& model : one_of_each()) CHECK(complaints_of(model).empty());
}

TEST_CASE("check: names") {
  auto renamed = [](const std::string& name) {
    auto m = pin();
    m.objects[0].name = name;
    return m;
  };
  expect_complaint(renamed("Body"), "lower-case");
  expect_complaint(renamed("module"), "reserved");
  expect_complaint(renamed("head_radius"), "used twice");
}

TEST_CASE("check: values, references and relations") {
  auto m = pin();
  m.parameters[0].value = -20;
  CHECK_FALSE(complaints_of(m).empty());
  m = pin();
  m.parameters.erase(m.parameters.begin());
  expect_complaint(m, "unknown parameter 'head_radius'");
  expect_complaint(model_with(Cylinder{0, 5}), "a length above 0");
  expect_complaint(model_with(Cone{0, 0, 5}), "one radius");
  expect_complaint(model_with(Torus{5, 6}), "below the ring's");
  expect_complaint(model_with(Superellipsoid{1, 1, 1, 3, 1, 0, 0}), "exponent");
  expect_complaint(model_with(Union{{"later"}}), "not an earlier object");
  expect_complaint(model_with(Cylinder{Expr(1) / Expr::of("zero"), 5}, {length("zero", 0)}), "no finite value");
  expect_complaint(model_with(HalfSpaces{{{1, 0, 0, 1, ""}, {-1, 0, 0, 1, ""}}}), "no bounded body");
}

TEST_CASE("check: sketches are simple, closed the right way round, and keep off the axis") {
  auto extruded = [](Loop loop) { return model_with(Extrude{{{loop}}, 5}); };
  expect_complaint(extruded(polygon({{0, 0}, {10, 10}, {10, 0}, {0, 10}})), "crosses itself");
  expect_complaint(extruded(polygon({{0, 0}, {10, 0}, {10, 5}, {11, 5}, {11, 0}, {5, 0}, {5, 8}, {0, 8}})),
                   "runs along itself");
  expect_complaint(extruded(polygon({{0, 0}, {10, 0}, {10, 10}, {5, 0}, {0, 10}})), "touches itself");
  // A wing that crosses the left edge where its corner is: no two edges cross inside both.
  expect_complaint(extruded(polygon({{0, 0}, {10, 0}, {10, 6}, {0, 6}, {-1, -9}, {0, 18}})), "touches itself");
  expect_complaint(extruded(polygon({{0, 0}, {0, 10}, {10, 10}, {10, 0}})), "counter-clockwise");
  expect_complaint(extruded(polygon({{0, 0}, {10, 0}})), "encloses nothing");
  expect_complaint(model_with(Revolve{{{polygon({{-1, 0}, {5, 0}, {5, 5}, {-1, 5}})}}}), "crosses the axis");
  Loop hole = polygon({{2, 2}, {4, 2}, {4, 4}, {2, 4}});
  expect_complaint(model_with(Extrude{{{polygon({{0, 0}, {10, 0}, {10, 10}, {0, 10}}), hole}}, 5}),
                   "must run clockwise");
  const Loop outer = polygon({{0, 0}, {10, 0}, {10, 10}, {0, 10}});
  const Loop far = polygon({{22, 2}, {22, 4}, {24, 4}, {24, 2}});
  expect_complaint(model_with(Extrude{{{outer, far}}, 5}), "outside the outer loop");
  const Loop large = polygon({{1, 1}, {1, 9}, {9, 9}, {9, 1}}), small = polygon({{2, 2}, {2, 4}, {4, 4}, {4, 2}});
  expect_complaint(model_with(Extrude{{{outer, large, small}}, 5}), "must run counter-clockwise");
}

TEST_CASE("check: a draft leaves every piece of the sketch its length, and the loops apart") {
  const Loop plate = polygon({{0, 0}, {20, 0}, {20, 12}, {0, 12}});
  auto drafted = [](std::vector<Loop> loops, double height, double below, double draft) {
    return model_with(Extrude{{std::move(loops)}, height, below, draft});
  };
  CHECK(complaints_of(drafted({plate}, 10, 3, 0.5)).empty());
  CHECK(complaints_of(drafted({plate}, 10, 3, -0.5)).empty());
  // Half of the width of 12 is used up by 10 tan(0.55), a height of 20 uses it up at any rate.
  expect_complaint(drafted({plate}, 10, 0, 0.55), "vanishes before the top");
  expect_complaint(drafted({plate}, 1, 20, -0.5), "vanishes before the bottom");
  expect_complaint(drafted({plate}, 10, 0, 1.6), "less than a quarter of a turn, found");
  const Loop bore{"bore", {SketchArc{6, 6, 2, 2 * pi, 0, "bore", ""}}},
      pin{"pin", {SketchArc{14, 6, 2, 2 * pi, 0, "pin", ""}}};
  CHECK(complaints_of(drafted({plate, bore, pin}, 10, 3, 0.1)).empty());
  expect_complaint(drafted({plate, bore, pin}, 10, 0, 0.25), "at the top: the sketch crosses itself");
  expect_complaint(drafted({plate, bore}, 1, 10, 0.2), "the radius of 'bore' comes to nothing before the bottom");
  // Behind a corner that is not tangent an arc would have to change its angles.
  const Loop dome{"dome", {SketchPoint{0, 0, "base"}, SketchPoint{20, 0, ""}, SketchArc{10, 0, 10, 0, pi, "dome", ""}}};
  expect_complaint(drafted({dome}, 1, 0, 0.1), "a corner between 'base' and 'dome'");
  SketchNurbs arch{2, {0, 0, 0, 1, 1, 1}, {}, {{20, 0}, {10, 20}, {0, 0}}, "arch", "base"};
  expect_complaint(drafted({Loop{"vault", {arch}}}, 1, 0, 0.1), "found the curve 'arch'");
  // A neck that closes: both of its sides meet.
  const Loop neck =
      polygon({{0, 0}, {8, 0}, {8, 3}, {12, 3}, {12, 0}, {20, 0}, {20, 8}, {12, 8}, {12, 5}, {8, 5}, {8, 8}, {0, 8}});
  CHECK(complaints_of(drafted({neck}, 9, 0, 0.1)).empty());
  CHECK_FALSE(complaints_of(drafted({neck}, 11, 0, 0.1)).empty());
  expect_complaint(model_with(Pocket{{{plate}}, 20, false, 1, 0.5}), "vanishes before the bottom");
  expect_complaint(model_with(Boss{{{plate}}, 20, 1, 0.5}), "vanishes before the top");
}

TEST_CASE("check: a bend keeps the body off the centre of its arc, and its ends apart") {
  auto bent = [](double a1, double taper, double bend) {
    return model_with(Superellipsoid{a1, 5, 20, 1, 1, taper, 0, bend});
  };
  CHECK(complaints_of(bent(9, 0, 2.1)).empty());
  CHECK(complaints_of(bent(9, 0, -2.1)).empty());
  expect_complaint(bent(9, 0.1, 2.1), "a radius above the half width 9.9, found 9.524");
  expect_complaint(bent(10, 0, -2.1), "a radius above the half width 10, found 9.524");
  expect_complaint(bent(1, 0, 3.2), "a bend of less than half a turn, found");
}

TEST_CASE("check: triangulations are manifold and face outward") {
  const TriSurface tetrahedron{
      {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}, true, 0};
  auto open = tetrahedron;
  open.triangles.pop_back();
  expect_complaint(model_with(open), "open edges");
  auto inward = tetrahedron;
  for (auto& t : inward.triangles) std::swap(t[0], t[1]);
  expect_complaint(model_with(inward), "face inward");
  auto bad = tetrahedron;
  bad.triangles[0][0] = 9;
  expect_complaint(model_with(bad), "names vertex 9");
}

TEST_CASE("check: relations of a sketch name pieces that exist, and hold") {
  Loop outline = polygon({{0, 0}, {10, 0}, {10, 6}, {0, 6}});
  const char* roles[] = {"front", "right", "back", "left"};
  for (std::size_t i = 0; i < 4; ++i) std::get<SketchPoint>(outline.elements[i]).edge = roles[i];
  const Loop bore{"bore", {SketchArc{3, 3, 1, 2 * pi, 0, "bore", ""}}},
      pin{"pin", {SketchArc{7, 3, 1, 2 * pi, 0, "pin", ""}}};
  auto with = [&](const SketchRelation& relation) {
    return model_with(Extrude{Sketch{{outline, bore, pin}, {relation}}, 5});
  };
  for (const SketchRelation& good : {SketchRelation{"parallel", "front", "back"},
                                     {"perpendicular", "front", "left"},
                                     {"equal", "left", "right"},
                                     {"equal", "bore", "pin"}})
    CHECK(std::holds_alternative<CheckedModel>(check(with(good))));
  expect_complaint(with({"parallel", "front", "left"}), "contradict it by 1");
  expect_complaint(with({"equal", "front", "left"}), "contradict it by 4");
  expect_complaint(with({"concentric", "bore", "pin"}), "contradict it by 4");
  expect_complaint(with({"parallel", "front", "lid"}), "expected one piece called 'lid', found 0");
  expect_complaint(with({"parallel", "front", "bore"}), "straight edges");
  expect_complaint(with({"tangent", "front", "back"}), "do not meet");
  expect_complaint(with({"beside", "front", "back"}), "as its kind");
  // A slot: its ends are tangent to its sides, and it is its own image behind both axes.
  const Loop slot{"slot",
                  {SketchArc{4, 0, 2, -pi / 2, pi / 2, "right end", "top"},
                   SketchArc{-4, 0, 2, pi / 2, 3 * pi / 2, "left end", "bottom"}}};
  for (const SketchRelation& good : {SketchRelation{"tangent", "right end", "top"},
                                     {"symmetric_y", "right end", "left end"},
                                     {"symmetric_x", "top", "bottom"},
                                     {"equal", "right end", "left end"}})
    CHECK(std::holds_alternative<CheckedModel>(check(model_with(Extrude{Sketch{{slot}, {good}}, 5}))));
}

TEST_CASE("check: a formula is computed, and refers to earlier parameters only") {
  Model m = model_with(Sphere{Expr::of("radius")}, {length("diameter", 14), length("radius", 0)});
  m.parameters[0].fitted = 14.02;
  m.parameters[1].formula = Expr::of("diameter") / Expr(2);
  const auto good = check(m);
  REQUIRE(std::holds_alternative<CheckedModel>(good));
  CHECK(std::get<CheckedModel>(good)->parameters[1].value == 7);
  CHECK(std::get<CheckedModel>(good)->parameters[1].fitted == Approx(7.01));
  std::swap(m.parameters[0], m.parameters[1]);
  expect_complaint(m, "unknown parameter 'diameter'");
  Model counted = model_with(Sphere{3}, {{"rows", Quantity::count, 2.5, 2.5}});
  expect_complaint(counted, "a whole number");
}

TEST_CASE("check: features make sense") {
  expect_complaint(model_with(Hole{6, 10, true, 2.0}), "has no tip");
  expect_complaint(model_with(Hole{6, 10, true, 0, 5, 3}), "wider than its hole");
  expect_complaint(model_with(Hole{6, 10, true, 0, 9, 0}), "a diameter and a depth");
  expect_complaint(model_with(Hole{6, 10, true, 0, 0, 0, 40}), "less deep than its hole");
  expect_complaint(model_with(Slot{6, 6, 4}), "above its width");
  expect_complaint(model_with(Revolve{{{polygon({{1, 0}, {5, 0}, {5, 5}})}}, 7}), "a full turn at most");
  Model m = model_with(Sphere{3});
  m.objects.push_back({"row", LinearPattern{"ball", 3, 10, 0, 0}, {}, {}, {}});
  expect_complaint(m, "'ball' is not an earlier object");
  m.objects[1].shape = LinearPattern{"body", 3, 0, 0, 0};
  expect_complaint(m, "must not be 0");
  m.objects[1].shape = Mirror{"body", "w", 0, true};
  expect_complaint(m, "expected axis x, y or z");
}
