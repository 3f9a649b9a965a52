/// Models in words, as the command line tells them.
#include "cli/describe.h"

#include <catch2/catch.hpp>

namespace partscribe::testing {

using namespace cli;

namespace {

Model ball() {
  Model model;
  model.name = "ball <1>";
  model.tolerance = 0.1;
  Parameter radius;
  radius.name = "radius";
  radius.value = 5;
  radius.fitted = 4.99731;
  radius.sigma = 0.0042;
  radius.points = 4120;
  radius.nominal = NominalEvidence{5, 0.64, true, "0.5 mm grid"};
  radius.note = "of the ball";
  model.parameters = {radius};
  Object object;
  object.name = "ball";
  object.shape = Sphere{Expr::of("radius")};
  model.objects = {object};
  model.rivals = {{"ellipsoid", true, 0.02, 312.5, "explains no more and needs two numbers more"}};
  return model;
}

/// What is left of a block of 30 x 40 x 120 mm (a diagonal of 130) where nothing met 0.1 mm.
Model triangulated_block() {
  Model model;
  model.name = "block";
  model.tolerance = 0.1;
  TriSurface surface;
  for (const double x : {0.0, 30.0})
    for (const double y : {0.0, 40.0})
      for (const double z : {0.0, 120.0}) surface.vertices.push_back({x, y, z});
  Object object;
  object.name = "body";
  object.shape = surface;
  model.objects = {object};
  model.fallback = true;
  return model;
}

}  // namespace

TEST_CASE("describe: a triangulation names the plainest procedure that came near") {
  Model model = triangulated_block();
  CHECK(nearest_procedure_line(model).empty());
  model.rivals = {{"extrusion", false, 1.62, 900, "deviates by 1.62 mm at (1, 2, 3)"},
                  {"box", false, 1.646, 950, "deviates by 1.65 mm at (1, 2, 3)"},
                  {"sphere", false, 30, 990, "deviates by 30 mm at (1, 2, 3)"},
                  {"extrusion", false, 3, 0, "makes no sense: the sketch crosses itself"}};
  const auto line = nearest_procedure_line(model);
  CHECK(line == "Nearest procedure: a box, off by up to 1.65 mm.");
  model.rivals[1].deviation = 1.9;  // no longer as near as the extrusion
  CHECK(nearest_procedure_line(model) == "Nearest procedure: an extrusion, off by up to 1.62 mm.");
  model.rivals = {
      {"sphere", false, 4.1, 990, "deviates by 4.1 mm at (1, 2, 3)"}};  // farther than three hundredths of the size
  CHECK(nearest_procedure_line(model).empty());
  model.rivals = {{"box", false, 1.65, 950, "deviates by 1.65 mm at (1, 2, 3)"}};
  model.fallback = false;  // a triangulation that was asked for
  CHECK(nearest_procedure_line(model).empty());
}

TEST_CASE("describe: a value carries as many digits as its uncertainty allows") {
  CHECK(with_sigma(10.99731, 0.0042) == "10.9973 ± 0.0042");
  CHECK(with_sigma(123.456, 1.7) == "123.5 ± 1.7");
  CHECK(with_sigma(7, 0) == "7");
}

TEST_CASE("describe: angles are shown in degrees and nominal evidence in words") {
  Parameter angle;
  angle.name = "draft";
  angle.quantity = Quantity::angle;
  angle.value = 0.78539816339744831;
  CHECK(describe(angle).value == "45");
  CHECK(describe(angle).unit == "deg");
  CHECK(describe(ball().parameters.front()).nominal == "5 (0.5 mm grid), 0.64 sigma away: taken");
}

TEST_CASE("describe: a fallback says that it is one") {
  Model model;
  TriSurface surface;
  surface.triangles.resize(724);
  Object object;
  object.name = "surface";
  object.shape = surface;
  model.objects = {object};
  model.fallback = true;
  CHECK(procedure_text(model) == "a triangulation of 724 triangles, because no procedure met 0.1 mm");
}

}  // namespace partscribe::testing
