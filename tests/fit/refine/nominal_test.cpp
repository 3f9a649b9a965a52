// Round sizes: believed when the part as a whole gives reason to, refused when it is worn, named as a shop names them.
#include "fit/refine/nominal.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "testing/models.h"

using namespace partscribe::fit;
using namespace partscribe::testing;

namespace {

Parameter measured(const char* name, double fitted, double sigma, Quantity quantity = Quantity::length) {
  Parameter p = length(name, fitted);
  p.fitted = fitted, p.sigma = sigma, p.quantity = quantity;
  return p;
}

std::vector<std::optional<NominalEvidence>> answers(const std::vector<Parameter>& parameters, double tolerance = 0.1) {
  return nominal_values(parameters, tolerance, 60);
}

bool kept(const std::optional<NominalEvidence>& e, double value) {
  return e && e->kept && std::abs(e->candidate - value) < 1e-9;
}

}  // namespace

TEST_CASE("nominal: the sizes of a metric part are found, each with its probability") {
  const auto found = answers({measured("length", 80.003, 0.004), measured("width", 25.002, 0.004),
                              measured("height", 7.497, 0.004), measured("hole_d", 6.602, 0.006)});
  CHECK(kept(found[0], 80));
  CHECK(kept(found[1], 25));
  CHECK(kept(found[2], 7.5));
  REQUIRE(kept(found[3], 6.6));
  CHECK(found[3]->series == "clearance of M6, medium");
  for (const auto& e : found) CHECK(e->probability > 0.9);
}

TEST_CASE("nominal: the sizes of an inch part are fractions, not tenths of a millimetre") {
  const auto found = answers({measured("length", 76.203, 0.004), measured("width", 38.098, 0.004),
                              measured("height", 9.527, 0.004), measured("bore_d", 12.702, 0.006)});
  CHECK(kept(found[0], 76.2));
  CHECK(kept(found[1], 38.1));
  CHECK(kept(found[2], 9.525));
  CHECK(kept(found[3], 12.7));
  CHECK(found[0]->series == "3 inch");
  CHECK(found[1]->series == "1 1/2 inch");
  CHECK(found[2]->series == "3/8 inch");
  CHECK(found[3]->series == "1/2 inch");
}

TEST_CASE("nominal: a drill of the inch tables is named") {
  const auto found = answers({measured("length", 127.002, 0.004), measured("width", 63.499, 0.004),
                              measured("height", 19.051, 0.004), measured("hole_d", 0.201 * 25.4, 0.002)});
  REQUIRE(found[3]);
  CHECK(found[3]->kept);
  CHECK(found[3]->series == "number drill 7");
}

TEST_CASE("nominal: a place on the other side of the origin is as round, in inches too") {
  const auto found =
      answers({measured("length", 76.203, 0.004), measured("width", 38.098, 0.004), measured("hole_x", -9.527, 0.004),
               measured("hole_y", -19.051, 0.004), measured("tilt", radians(-14.999), 1e-4, Quantity::angle)});
  CHECK(kept(found[2], -9.525));
  CHECK(kept(found[3], -19.05));
  CHECK(kept(found[4], radians(-15)));
}

TEST_CASE("nominal: a worn part is not believed the size that chance puts on a fine grid") {
  const std::vector<Parameter> worn = {measured("length", 79.873, 0.004), measured("width", 24.919, 0.004),
                                       measured("height", 7.461, 0.004), measured("step", 12.301, 0.004)};
  for (const auto& e : answers(worn)) CHECK_FALSE((e && e->kept));
  // Among round sizes the same measurement is taken.
  const auto found = answers({measured("length", 79.9, 0.004), measured("width", 24.7, 0.004),
                              measured("height", 7.4, 0.004), measured("step", 12.301, 0.004)});
  CHECK(kept(found[3], 12.3));
}

TEST_CASE("nominal: a near miss is reported and refused") {
  const auto found = answers({measured("length", 9.96, 0.003)});
  REQUIRE(found[0]);
  CHECK_FALSE(found[0]->kept);
  CHECK(found[0]->candidate == 10);
  CHECK(found[0]->z == Approx(0.04 / 0.003));
}

TEST_CASE("nominal: loose measurements prove nothing, and nothing moves by more than a quarter of the tolerance") {
  CHECK_FALSE(answers({measured("length", 9.98, 3)})[0].has_value());
  const auto wide = answers({measured("length", 49.94, 0.05)}, 0.1);
  CHECK_FALSE((wide[0] && wide[0]->kept));
}

TEST_CASE("nominal: arbitrary sizes are believed round in no more than a few cases of a hundred") {
  Random random(7);
  int taken = 0;
  constexpr int parts = 300;
  for (int i = 0; i < parts; ++i) {
    std::vector<Parameter> sizes;
    for (int k = 0; k < 5; ++k) sizes.push_back(measured("length", 5 + 95 * random.uniform(), 0.005));
    for (const auto& e : answers(sizes)) taken += e && e->kept;
  }
  CHECK(taken < 0.01 * 5 * parts);
}

TEST_CASE("nominal: sizes meant in whole and half millimetres are recognised in nearly all cases, and never wrongly") {
  Random random(8);
  int right = 0, wrong = 0;
  constexpr int parts = 200;
  for (int i = 0; i < parts; ++i) {
    std::vector<Parameter> sizes;
    std::vector<double> truth;
    for (int k = 0; k < 5; ++k) {
      truth.push_back(0.5 * std::floor(10 + 190 * random.uniform()));
      sizes.push_back(measured("length", truth.back() + 0.005 * random.normal(), 0.005));
    }
    const auto found = answers(sizes);
    for (int k = 0; k < 5; ++k)
      if (found[k] && found[k]->kept) ++(std::abs(found[k]->candidate - truth[k]) < 1e-9 ? right : wrong);
  }
  CHECK(right > 0.95 * 5 * parts);
  CHECK(wrong <= 2);
}

TEST_CASE("nominal: angles take degrees") {
  const auto found = answers({measured("taper", 29.999 * pi / 180, 0.002 * pi / 180, Quantity::angle)});
  REQUIRE(found[0]);
  CHECK(found[0]->kept);
  CHECK(found[0]->candidate == Approx(pi / 6));
}
