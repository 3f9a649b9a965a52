/// Claims about parts whose only fault is their place, size, unit or hand: it is said, and not said of other faults.
#include <catch2/catch.hpp>

#include "testing/meshes.h"

using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

/// A block with a boss and an ear: no symmetry at all.
TriangleMesh part() {
  return joined(joined(box({0, 0, 0}, {50, 40, 20}), box({8, 6, 20.001}, {26, 18, 32})),
                box({30, 25, 20.001}, {44, 36, 25}));
}

std::string reasons_of(const TriangleMesh& artifact, const Scan& scan) {
  VerifyOptions options;
  options.tolerance = 0.2;
  const auto verdict = verdict_on(artifact, scan, options);
  CHECK(verdict.verdict == Outcome::out_of_tolerance);
  return all_reasons(verdict);
}

}  // namespace

TEST_CASE("whole part: a wrong place, size, unit or hand is said in words") {
  const Scan scan = scanned(part(), 30000, 0.03);
  auto says = [&](const TriangleMesh& artifact, const std::string& words) {
    const std::string reasons = reasons_of(artifact, scan);
    INFO(reasons);
    CHECK(reasons.find("the whole part is " + words) != std::string::npos);
  };
  says(moved(part(), {0.4, 0, 0}), "moved by (0.4");
  says(moved(part(), {100, -50, 20}), "moved by (100");
  says(scaled(part(), 1.016), "scaled by 1.016");
  says(scaled(part(), 25.4), "25.4 times too large: inches");
  says(scaled(part(), 1 / 25.4), "25.4 times too small: inches");
  says(scaled(part(), 1000), "1000 times too large");
  says(mirrored(part()), "mirrored");
  says(transformed(part(), {rotation_of({0.02, 0, 0}), {0, 0, 0}}), "turned by 1.1");
  says(transformed(part(), {rotation_of({0.5, 1.9, -0.7}), {30, 20, 10}}), "turned by");
}

TEST_CASE("whole part: nothing is said of a part with a fault of one feature") {
  const Scan scan = scanned(part(), 30000, 0.03);
  auto silent = [&](const TriangleMesh& artifact) {
    const std::string reasons = reasons_of(artifact, scan);
    INFO(reasons);
    CHECK(reasons.find("the whole part") == std::string::npos);
  };
  const auto ear = box({30, 25, 20.001}, {44, 36, 25}), boss = box({8, 6, 20.001}, {26, 18, 32});
  silent(joined(joined(box({0, 0, 0}, {50, 40, 20}), moved(boss, {0.4, 0, 0})), ear));
  silent(joined(joined(box({0, 0, 0}, {50.4, 40, 20}), boss), ear));
  silent(joined(box({0, 0, 0}, {50, 40, 20}), boss));
}
