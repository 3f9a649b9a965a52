/// Where scanned plane faces end: at the body, or in a shadow.
#include "fit/evidence/face_ends.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/random.h"

using namespace partscribe::fit;

namespace {

Candidate ell() {
  Loop outline;
  outline.name = "outline";
  outline.elements = {SketchPoint{0, 0, ""},   SketchPoint{60, 0, ""},  SketchPoint{60, 15, ""},
                      SketchPoint{25, 15, ""}, SketchPoint{25, 40, ""}, SketchPoint{0, 40, ""}};
  Candidate c;
  c.object_name = "plate", c.shape = Extrude{{{outline}}, Expr(20)};
  return c;
}

Candidate block() {
  Candidate c;
  c.object_name = "block", c.shape = Box{60, 40, 20};
  return c;
}

/// Points of the upper end alone, where `lit` says so.
FitInput end_face(const std::function<bool(double, double)>& lit) {
  FitInput input;
  Random random(3);
  while (input.cloud.size() < 1500) {
    const double x = random.uniform(0, 60), y = random.uniform(0, 40), noise = 0.05 * random.normal();
    if (!lit(x, y)) continue;
    input.cloud.points.emplace_back(x, y, 20 + noise), input.cloud.normals.emplace_back(0, 0, 1);
  }
  input.tolerance = 0.2, input.sampling.sigma = 0.05, input.bounds = input.cloud.bounds();
  return input;
}

}  // namespace

TEST_CASE("face ends: a face that is an L is one of an L, seen whole or with a shadow on it") {
  const auto is_ell = [](double x, double y) { return x < 25 || y < 15; };
  const auto shaded = [&](double x, double y) {
    return is_ell(x, y) && std::hypot(x - 20, y - 30) > 6 && std::hypot(x - 60, y) > 8;
  };
  CHECK(face_ends_told(ell(), block(), end_face(is_ell)) > 25);
  CHECK(face_ends_told(ell(), block(), end_face(shaded)) > 20);
  CHECK(face_ends_told(block(), ell(), end_face(is_ell)) < -25);
}

TEST_CASE("face ends: a block with a round shadow across its corner is no L, and one seen whole speaks against it") {
  const auto shaded = [](double x, double y) { return std::hypot(x - 60, y - 40) > 38; };
  CHECK(face_ends_told(ell(), block(), end_face(shaded)) < 5);
  CHECK(face_ends_told(ell(), block(), end_face([](double, double) { return true; })) < -20);
}

TEST_CASE("face ends: faces of which nothing was seen where two bodies differ say nothing") {
  const auto left = [](double x, double) { return x < 15; };
  CHECK(face_ends_told(ell(), block(), end_face(left)) == 0);
  CHECK(face_ends_told(ell(), ell(), end_face(left)) == 0);
}
