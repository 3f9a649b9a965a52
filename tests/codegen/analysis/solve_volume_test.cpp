/// Values found for a wished volume, against those that a formula gives.
#include "codegen/analysis/solve_volume.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "testing/checked_model.h"
#include "testing/models.h"

namespace partscribe::testing {

using namespace codegen;

namespace {

Result<SolvedVolume> solved(const Model& m, const std::string& name, double volume) {
  Context context;
  return solve_volume(checked_model(m), name, volume, context);
}

Model ball() { return model_with(Sphere{Expr::of("radius")}, {length("radius", 11)}); }
Model drilled() { return one_of_each().back(); }

}  // namespace

TEST_CASE("solve volume: the radius of a sphere, smaller and ten times larger") {
  for (const double radius : {4.0, 110.0}) {
    const auto found = solved(ball(), "radius", 4 * pi / 3 * radius * radius * radius);
    REQUIRE(found.ok());
    CHECK(found->found);
    CHECK(found->value == Approx(radius).epsilon(1e-6));
    CHECK(found->volume == Approx(4 * pi / 3 * radius * radius * radius).epsilon(1e-6));
    CHECK(found->builds < 40);
    CHECK(snapped(found->value, 1e-6) == found->value);  // a number to print, not eleven digits of a search
  }
}

TEST_CASE("solve volume: a bore grows until the block is light enough") {
  const auto found = solved(drilled(), "bore_radius", 6000);
  REQUIRE(found.ok());
  CHECK(found->found);
  CHECK(found->value == Approx(std::sqrt(2000 / (pi * 20))).epsilon(1e-6));
}

TEST_CASE("solve volume: a volume that the model has leaves the parameter as it is") {
  const auto found =
      solved(model_with(Box{Expr::of("side"), 10, 10}, {length("side", 10.123456789)}), "side", 1012.3456789);
  REQUIRE(found.ok());
  CHECK(found->found);
  CHECK(found->value == 10.123456789);
}

TEST_CASE("solve volume: angles are found as well") {
  Parameter sweep = length("sweep", 2);
  sweep.quantity = Quantity::angle;
  const auto found = solved(
      model_with(Revolve{{{polygon({{6, 0}, {14, 0}, {14, 9}, {6, 9}})}}, Expr::of("sweep")}, {sweep}), "sweep", 2160);
  REQUIRE(found.ok());
  CHECK(found->found);
  CHECK(found->value == Approx(3).epsilon(1e-6));
}

TEST_CASE("solve volume: where no value will do, the range that was tried is told and why it ends") {
  // The block is 8000 mm^3 before it is drilled.
  const auto found = solved(drilled(), "bore_radius", 9000);
  REQUIRE(found.ok());
  CHECK_FALSE(found->found);
  CHECK(found->most < 8000);
  CHECK(found->most > 7990);
  CHECK(found->volume == found->most);
  CHECK(found->low > 0);
  CHECK_FALSE(found->limit.empty());
}

TEST_CASE("solve volume: a parameter that does nothing to the volume is not found to reach another") {
  Model m = model_with(Box{10, 10, 10}, {length("shift", 5)});
  m.objects[0].frame.x = Expr::of("shift");
  const auto found = solved(m, "shift", 900);
  REQUIRE(found.ok());
  CHECK_FALSE(found->found);
  CHECK(found->least == Approx(1000));
  CHECK(found->most == Approx(1000));
}

TEST_CASE("solve volume: bad_parameter: unknown, computed and counted ones are refused") {
  const auto unknown = solved(ball(), "diameter", 100);
  REQUIRE_FALSE(unknown.ok());
  CHECK(unknown.error().kind == ErrorKind::usage);
  CHECK(unknown.error().message.find("(radius)") != std::string::npos);
  Parameter count = length("pins", 4);
  count.quantity = Quantity::count;
  Model row = model_with(Cylinder{2, 10}, {count});
  row.objects[0].name = "pin";
  row.objects.push_back({"row", LinearPattern{"pin", Expr::of("pins"), 10, 0, 0}, {}, {}, {}});
  const auto counted = solved(row, "pins", 1000);
  REQUIRE_FALSE(counted.ok());
  CHECK(counted.error().message.find("whole numbers") != std::string::npos);
}

}  // namespace partscribe::testing
