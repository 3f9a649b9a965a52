// Numbers for print: round ones only with evidence, and never far from what was measured.
#include "fit/refine/tidy.h"

#include <catch2/catch.hpp>

#include "core/number.h"
#include "testing/models.h"

using namespace partscribe::fit;
using namespace partscribe::testing;

namespace {

Parameter snapped_length(double fitted, double sigma, double tolerance = 0.1) {
  Candidate c;
  c.shape = Sphere{Expr::of("radius")};
  c.parameters = {length("radius", fitted)};
  c.parameters[0].sigma = sigma;
  snap_parameters(c, {.tolerance = tolerance, .size = 50});
  return c.parameters[0];
}

}  // namespace

TEST_CASE("nominal: a value on a coarse grid is taken, with its evidence") {
  const Parameter p = snapped_length(9.998, 0.003);
  CHECK(p.value == 10);
  CHECK(p.fitted == Approx(9.998).margin(1e-4));
  REQUIRE(p.nominal);
  CHECK(p.nominal->kept);
  CHECK(p.nominal->series == "multiples of 10 mm");
  CHECK(std::abs(p.nominal->z) < 1);
}

TEST_CASE("nominal: a value measured beside the grid is refused, and the script says so") {
  const Parameter p = snapped_length(9.96, 0.003);
  CHECK(p.value == Approx(9.96));
  REQUIRE(p.nominal);
  CHECK_FALSE(p.nominal->kept);
  CHECK(p.nominal->candidate == 10);
  CHECK(p.nominal->z == Approx(0.04 / 0.003).epsilon(0.01));
}

TEST_CASE("nominal: a loose measurement proves no grid") {
  const Parameter p = snapped_length(9.98, 3);
  CHECK_FALSE((p.nominal && p.nominal->kept));
  CHECK(p.value == Approx(9.98).margin(0.01));
}

TEST_CASE("nominal: no round number moves a surface by more than a quarter of the tolerance") {
  const Parameter p = snapped_length(9.97, 0.05, 0.1);
  CHECK(std::abs(p.value - 9.97) <= 0.025 + 1e-9);
}

TEST_CASE("tidy: printed values are the values") {
  for (const double v : {1.23456789, 17.0000123, 0.333333}) {
    const Parameter p = snapped_length(v, 0.004);
    CHECK(print_number(p.value).size() <= 7);
    CHECK(std::abs(p.value - v) < 0.0015);
  }
}

TEST_CASE("tidy: normals that are square within the tolerance become square") {
  Candidate c;
  c.shape =
      HalfSpaces{{{1.0000000000000004, 5.6e-17, -0.00002, Expr::of("face_1_offset"), ""}, {0.6, 0.8, 0.00001, 5, ""}}};
  c.parameters = {length("face_1_offset", 7)};
  snap_parameters(c, {.tolerance = 0.1, .size = 50});
  const auto& planes = std::get<HalfSpaces>(c.shape).planes;
  CHECK(planes[0].normal_x == Expr(1));
  CHECK(planes[0].normal_y == Expr(0));
  CHECK(planes[0].normal_z == Expr(0));
  CHECK(planes[1].normal_x == Expr(0.6));
  CHECK(planes[1].normal_z == Expr(0));
}

TEST_CASE("placement: a turn that the shape does not feel is left out, one that nobody sees is made round") {
  FitInput input;
  input.tolerance = 0.1;
  input.bounds.add({-25, -25, -25});
  input.bounds.add({25, 25, 25});
  Candidate ball;
  ball.object_name = "ball";
  ball.shape = Sphere{11};
  ball.scan_from_part = {rotation_of({0.3, 0.2, 0.1}), {1.23456, 0.0001, -7}};
  const Model m = model_of(ball, input);
  CHECK(m.scan_from_part.rx == Expr(0));
  CHECK(m.scan_from_part.y == Expr(0));
  CHECK(m.scan_from_part.x == Expr(1.235));
  Candidate rod;
  rod.object_name = "rod";
  rod.shape = Cylinder{8, 25};
  rod.scan_from_part.rotation = rotation_of({pi / 2 + 1e-5, 0, 0}) * rotation_of({0, 0, 1.1});
  const Model r = model_of(rod, input);
  CHECK(r.scan_from_part.rx == Expr(radians(90)));
  CHECK(r.scan_from_part.rz == Expr(0));
}
