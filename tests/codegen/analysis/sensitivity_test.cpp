/// Sensitivities against derivatives taken by hand.
#include "codegen/analysis/sensitivity.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "testing/checked_model.h"
#include "testing/models.h"

namespace partscribe::testing {

using namespace codegen;

namespace {

std::vector<Sensitivity> sensitivities_of(const Model& m, const SensitivityOptions& options = {}) {
  Context context;
  const auto model = checked_model(m);
  const auto body = mass_properties(model, context);
  REQUIRE(body.ok());
  const auto all = sensitivities(model, *body, options, context);
  REQUIRE(all.ok());
  return *all;
}

Sensitivity of(const std::vector<Sensitivity>& all, const std::string& name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const auto& s) { return s.parameter == name; });
  INFO(name);
  REQUIRE(found != all.end());
  return *found;
}

Model block() {
  const auto p = [](const char* name) { return Expr::of(name); };
  return model_with(Box{p("length"), p("width"), p("height")},
                    {length("length", 30), length("width", 20), length("height", 10)});
}

}  // namespace

TEST_CASE("sensitivity: of a box it is the derivative that is taken by hand") {
  const auto all = sensitivities_of(block());
  REQUIRE(all.size() == 3);
  const auto s = of(all, "length");
  CHECK(s.fault == "");
  CHECK_FALSE(s.one_sided);
  CHECK_FALSE(s.kink);
  CHECK(s.change.volume == Approx(200).epsilon(1e-8));
  CHECK(s.change.area == Approx(60).epsilon(1e-8));
  CHECK((s.change.centroid - Vec3(0.5, 0, 0)).norm() < 1e-8);
  // I = a b c (b^2 + c^2) / 12, a b c (a^2 + c^2) / 12, a b c (a^2 + b^2) / 12
  const Vec3 slopes(200 * 500 / 12.0, 200 * (3 * 900 + 100) / 12.0, 200 * (3 * 900 + 400) / 12.0);
  for (int k = 0; k < 3; ++k) {
    CHECK(s.change.inertia(k, k) == Approx(slopes[k]).epsilon(1e-6));
    CHECK(s.moments[k] == Approx(slopes[k]).epsilon(1e-6));  // the box lies along its axes, smallest moment first
  }
  // One mm of the smallest side is the largest share of the part.
  CHECK(all[0].parameter == "height");
  CHECK(all[2].parameter == "length");
}

TEST_CASE("sensitivity: steps that are too large miss the derivative, as these checks can tell") {
  const auto s = of(sensitivities_of(block(), {.step = 0.3}), "length");
  CHECK(s.moments[2] != Approx(200 * (3 * 900 + 400) / 12.0).epsilon(1e-3));
}

TEST_CASE("sensitivity: a bore takes material away, the block around it gives some") {
  const auto all = sensitivities_of(one_of_each().back());
  const double size = 20, radius = 4;
  CHECK(of(all, "bore_radius").change.volume == Approx(-2 * pi * radius * size).epsilon(1e-6));
  CHECK(of(all, "size").change.volume == Approx(3 * size * size - pi * radius * radius).epsilon(1e-6));
}

TEST_CASE("sensitivity: of an angle it is per radian, of a count per one more") {
  Parameter sweep = length("sweep", 2);
  sweep.quantity = Quantity::angle;
  const auto turned = sensitivities_of(
      model_with(Revolve{{{polygon({{6, 0}, {14, 0}, {14, 9}, {6, 9}})}}, Expr::of("sweep")}, {sweep}));
  CHECK(of(turned, "sweep").change.volume == Approx(8 * 9 * 10).epsilon(1e-7));

  Parameter count = length("pins", 4);
  count.quantity = Quantity::count;
  Model row = model_with(Cylinder{2, 10}, {count});
  row.objects[0].name = "pin";
  row.objects.push_back({"row", LinearPattern{"pin", Expr::of("pins"), 10, 0, 0}, {}, {}, {}});
  const auto counted = of(sensitivities_of(row), "pins");
  CHECK(counted.step == 1);
  CHECK(counted.change.volume == Approx(40 * pi).epsilon(1e-9));
  CHECK(counted.change.centroid.x() == Approx(5).epsilon(1e-9));
}

TEST_CASE("sensitivity: what follows by a formula moves along, and has no row of its own") {
  Model cube = model_with(Box{Expr::of("a"), Expr::of("b"), 10}, {length("a", 10), length("b", 0)});
  cube.parameters[1].formula = Expr::of("a") * Expr(2);
  const auto all = sensitivities_of(cube);
  REQUIRE(all.size() == 1);
  CHECK(all[0].change.volume == Approx(400).epsilon(1e-7));  // 2 a^2 10
}

TEST_CASE("sensitivity: where a model can only grow one side is taken, and said") {
  const auto all = sensitivities_of(model_with(Wedge{30, 20, 10, Expr::of("top")}, {length("top", 0)}));
  REQUIRE(all.size() == 1);
  CHECK(all[0].one_sided);
  CHECK(all[0].change.volume == Approx(20 * 10 / 2.0).epsilon(1e-6));
}

TEST_CASE("sensitivity: where a step comes out of a face the two sides differ, and it is said") {
  Model step = model_with(Box{10, 10, 10}, {length("reach", 10)});
  step.objects.push_back({"bar", Box{Expr::of("reach"), 5, 5}, {}, {}, {}});
  step.objects.push_back({"both", Union{{"body", "bar"}}, {}, {}, {}});
  const auto all = sensitivities_of(step);
  REQUIRE(all.size() == 1);
  CHECK(all[0].kink);
  CHECK(all[0].change.volume == Approx(12.5).epsilon(1e-6));  // the mean of 0 and 25
}

TEST_CASE("sensitivity: a parameter that cannot change has a reason instead of numbers") {
  // The normal of a half space has unit length: one part of it cannot change alone.
  Model lone = model_with(HalfSpaces{{{-1, 0, 0, 0, "left"},
                                      {0, -1, 0, 0, "front"},
                                      {0, 0, -1, 0, "bottom"},
                                      {1, 0, 0, 10, "right"},
                                      {0, 1, 0, 10, "back"},
                                      {0, 0, Expr::of("unit"), 10, "top"}}},
                          {length("unit", 1)});
  const auto all = sensitivities_of(lone);
  REQUIRE(all.size() == 1);
  CHECK_FALSE(all[0].fault.empty());
  CHECK(all[0].fault.find("unit = ") == 0);
  CHECK(all[0].change.volume == 0);
}

TEST_CASE("sensitivity: the sigma of the mass comes from those of the parameters") {
  Model m = block();
  m.parameters[0].sigma = 0.01, m.parameters[1].sigma = 0.03;
  const auto sigma = mass_sigma(sensitivities_of(m));
  CHECK(sigma.volume == Approx(std::hypot(200 * 0.01, 300 * 0.03)).epsilon(1e-7));
  CHECK(sigma.area == Approx(std::hypot(60 * 0.01, 80 * 0.03)).epsilon(1e-7));
  CHECK((sigma.centroid - Vec3(0.005, 0.015, 0)).norm() < 1e-9);
  CHECK(sigma.known.size() == 2);
  CHECK(mass_sigma(sensitivities_of(block())).volume == 0);
}

TEST_CASE("sensitivity: bad_name: an unknown parameter names those that exist, a computed one those it comes from") {
  Model m = block();
  m.parameters.push_back(length("twice", 60));
  m.parameters.back().formula = Expr::of("length") * Expr(2);
  const auto model = checked_model(m);
  const auto unknown = with_value(model, "lenght", 3);
  REQUIRE_FALSE(unknown.ok());
  CHECK(unknown.error().kind == ErrorKind::usage);
  CHECK(unknown.error().message == "expected a parameter of the model (length, width, height), found 'lenght'");
  const auto computed = with_value(model, "twice", 3);
  REQUIRE_FALSE(computed.ok());
  CHECK(computed.error().message == "parameter 'twice' is computed from length; change those");
  const auto longer = with_value(model, "length", 40);
  REQUIRE(longer.ok());
  CHECK((*longer)->parameters[3].value == 80);
  CHECK(with_value(model, "length", -1).error().kind == ErrorKind::bad_input);
}

TEST_CASE("sensitivity: stops when it is told to") {
  Context context;
  const auto model = checked_model(block());
  const auto body = mass_properties(model, context);
  REQUIRE(body.ok());
  context.cancelled = true;
  const auto all = sensitivities(model, *body, {}, context);
  REQUIRE_FALSE(all.ok());
  CHECK(all.error().kind == ErrorKind::stopped);
}

}  // namespace partscribe::testing
