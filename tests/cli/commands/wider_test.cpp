/// A tolerance is named only where a build at it is verified.
#include "cli/commands/wider.h"

#include <catch2/catch.hpp>

namespace partscribe::testing {

using namespace cli;

namespace {

Verdict refused_for(double tolerance, std::vector<double> deviations) {
  Verdict verdict;
  verdict.tolerance = tolerance;
  verdict.verdict = Outcome::out_of_tolerance;
  ArtifactVerdict& row = verdict.artifacts.emplace_back();
  for (const double d : deviations) {
    Finding finding;
    finding.kind = Finding::Kind::displaced;
    finding.deviation = d;
    row.findings.push_back(finding);
  }
  return verdict;
}

/// Verified at `least` and wider, else off by hardly less.
struct Procedure {
  std::string name;
  double least;
};

struct Trials {
  std::vector<Procedure> procedures;
  std::vector<Wider> asked;

  Result<std::optional<Verdict>> operator()(const Wider& wider) {
    asked.push_back(wider);
    for (const auto& [name, least] : procedures) {
      if (name != wider.procedure) continue;
      if (wider.tolerance < least) return std::optional(refused_for(wider.tolerance, {0.999 * least}));
      Verdict verdict;
      verdict.verdict = Outcome::verified;
      return std::optional(verdict);
    }
    return std::optional<Verdict>();
  }
};

}  // namespace

TEST_CASE("wider: the tolerance named is one that was verified, not the one that the fit hoped for") {
  Trials trials{{{"box", 0.4106}}, {}};
  const auto found = first_verified({{"box", 0.4}}, 3, std::ref(trials));
  REQUIRE(found.ok());
  REQUIRE(found->has_value());
  CHECK((*found)->procedure == "box");
  CHECK((*found)->tolerance >= 0.4106);
  CHECK((*found)->tolerance < 0.45);
  CHECK(trials.asked.size() == 2);
}

TEST_CASE("wider: the least tolerance is tried first, and a procedure that is not found gives way to the next") {
  Trials trials{{{"box", 1.6}, {"extrude", 0.9}}, {}};
  const auto found =
      first_verified({{"box", 1.7}, {"cone", 0.5}, {"extrude", 1}, {"extrude", 0.95}}, 3, std::ref(trials));
  REQUIRE((found.ok() && found->has_value()));
  CHECK((*found)->procedure == "extrude");
  CHECK((*found)->tolerance == 0.95);
  CHECK(trials.asked.size() == 2);
}

TEST_CASE("wider: nothing is named where three trials do not verify, or where that takes a tolerance of no use") {
  Trials shy{{{"box", 100}}, {}};
  CHECK_FALSE(first_verified({{"box", 1}}, 3, std::ref(shy))->has_value());
  CHECK(shy.asked.size() == 1);
  Trials none{{}, {}};
  CHECK_FALSE(first_verified({{"box", 1}, {"cone", 1}, {"wedge", 2}, {"torus", 2}}, 3, std::ref(none))->has_value());
  CHECK(none.asked.size() == 3);
}

TEST_CASE("wider: what is wrong by no known distance is let by no tolerance") {
  CHECK(wider_for("box", refused_for(0.1, {0.2, 0.3}), 3)->tolerance == 0.31);
  CHECK_FALSE(wider_for("box", refused_for(0.1, {0.2, 0}), 3).has_value());
  CHECK_FALSE(wider_for("box", refused_for(0.1, {}), 3).has_value());
  CHECK_FALSE(wider_for("box", refused_for(0.1, {5}), 3).has_value());
}

}  // namespace partscribe::testing
