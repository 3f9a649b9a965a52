/// Sizes of features agree with the scan.
#include "verify/features/inspect.h"

#include <catch2/catch.hpp>

#include "testing/meshes.h"
#include "verify/features/features.h"

using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

constexpr double T = 0.1;
constexpr double sigma = 0.02;

VerifyOptions options() {
  VerifyOptions o;
  o.tolerance = T;
  return o;
}

std::string texts(const Verdict& verdict) {
  std::string text;
  for (const auto& f : verdict.artifacts[0].findings) text += std::string(name_of(f.kind)) + ": " + f.text + "\n";
  return text;
}

const FeatureVerdict* row(const Verdict& verdict, const std::string& name) {
  for (const auto& o : verdict.artifacts[0].objects)
    if (o.name == name) return &o;
  return nullptr;
}

const FeatureDimension* dimension(const FeatureVerdict& row, const std::string& name) {
  for (const auto& d : row.dimensions)
    if (d.name == name) return &d;
  return nullptr;
}

std::size_t faults(const Verdict& verdict) {
  std::size_t count = 0;
  for (const auto& f : verdict.artifacts[0].findings) count += f.kind != Finding::Kind::not_scanned;
  return count;
}

}  // namespace

TEST_CASE("inspection: the numbers of a true model agree with the scan, and nothing is found") {
  const auto truth = holed_plate(40, 10, 6, 5, -8);
  const auto verdict = verdict_on(truth, scanned(truth, 60000, sigma), options());
  INFO(texts(verdict));
  CHECK(verdict.verdict == Outcome::verified);
  CHECK(faults(verdict) == 0);
  const auto* hole = row(verdict, "hole 1");
  REQUIRE(hole);
  CHECK(hole->kind == "hole");
  const auto *diameter = dimension(*hole, "diameter"), *x = dimension(*hole, "position x"),
             *y = dimension(*hole, "position y");
  REQUIRE(diameter);
  REQUIRE(x);
  REQUIRE(y);
  CHECK(diameter->nominal == Approx(12).margin(1e-4));
  CHECK(std::abs(diameter->deviation) < 5 * diameter->sigma);
  CHECK(diameter->sigma < 0.01);
  CHECK(x->nominal == Approx(5).margin(1e-4));
  CHECK(std::abs(x->deviation) < 5 * x->sigma);
  CHECK(std::abs(y->deviation) < 5 * y->sigma);
  CHECK_FALSE(dimension(*hole, "position z"));
  const auto* top = row(verdict, "face +z at 10");
  REQUIRE(top);
  REQUIRE(dimension(*top, "position z"));
  CHECK(dimension(*top, "position z")->measured == Approx(10).margin(0.005));
}
