/// Each constraint of 1993 leaves out what it is there for, and nothing else.
#include "scan/register/as_published/constraints.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/number.h"
#include "core/random.h"
#include "scan/register/register_pair.h"
#include "testing/registration/cases.h"

using namespace partscribe::scan;
using namespace partscribe::testing::registration;

TEST_CASE("constraints: points are visible where an earlier view looked at their face, and nowhere else") {
  auto scanner = small();
  scanner.bit_error = 0;
  const Case scan = scan_of(cut_block(), scanner, 0, 0);
  Context context;
  const std::vector<ViewSurface> surfaces = view_surfaces(scan.views, 500, context, false);
  // The block is convex: a face is seen whole if it faces the sensor, and else not at all.
  int seen = 0, unseen = 0;
  for (const std::size_t v : {1, 2, 4, 7}) {
    const auto points = reference_points(surfaces[v], {});
    const auto visible = visible_points(points, scan.truth[v], {{&surfaces[0], scan.truth[0]}}, 4);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double facing = -(scan.truth[v].rotation * points[i].normal).dot(scan.truth[0].rotation.col(2));
      if (facing > -0.1 && facing < 0.55) continue;  // seen at a slant does not count
      INFO("view " << v << ", point " << i << ", facing " << facing);
      CHECK(bool(visible[i]) == (facing > 0));
      ++(visible[i] ? seen : unseen);
    }
  }
  CHECK(seen > 20);
  CHECK(unseen > 20);
}

TEST_CASE("constraints: a point behind what was measured is not visible, although it faces the sensor") {
  auto scanner = small();
  scanner.views = "1", scanner.tilt = 0, scanner.bit_error = 0, scanner.sigma = 0;
  const Case scan = scan_of(plain_block(), scanner, 0, 0);
  Context context;
  const std::vector<ViewSurface> surfaces = view_surfaces(scan.views, 500, context, false);
  const Vec3 up = Vec3::UnitZ();
  const std::vector<ReferencePoint> points{{{0, 0, 20}, up}, {{0, 0, 12}, up}, {{0, 0, 28}, up}, {{0, 40, 20}, up}};
  const auto visible = visible_points(points, {}, {{&surfaces[0], scan.truth[0]}}, 4);
  CHECK(visible == std::vector<std::uint8_t>{1, 0, 0, 0});
  // As far before or behind as the margin says it is visible still: the estimate is a rough one.
  CHECK(visible_points(points, {}, {{&surfaces[0], scan.truth[0]}}, 10) == std::vector<std::uint8_t>{1, 1, 1, 0});
}

TEST_CASE("constraints: the distribution of residuals tells mismatches, as long as they are not predominant") {
  Random random(4);
  std::vector<double> residuals;
  for (int k = 0; k < 50; ++k) residuals.push_back(0.1 * std::abs(random.normal()));
  for (int k = 0; k < 50; ++k) residuals.push_back(1 + 3 * random.uniform());
  const double limit = mismatch_limit(residuals, 3);
  CHECK(limit > *std::max_element(residuals.begin(), residuals.begin() + 50));
  CHECK(limit < 1);
  // Mean and deviation of all would let most of these mismatches pass.
  const double mean = std::accumulate(residuals.begin(), residuals.end(), 0.0) / 100;
  double variance = 0;
  for (const double r : residuals) variance += (r - mean) * (r - mean) / 100;
  CHECK(mean + 2 * std::sqrt(variance) > 3);
  // It scales with the residuals, and nothing is a mismatch where none is asked for.
  for (double& r : residuals) r *= 7;
  CHECK(mismatch_limit(residuals, 3) == Approx(7 * limit));
  CHECK(std::isinf(mismatch_limit(residuals, std::numeric_limits<double>::infinity())));
  // Predominant mismatches become the rule.
  for (std::size_t k = 0; k < 20; ++k) residuals[k] = 20;
  CHECK(mismatch_limit(residuals, 3) > 20);
}

TEST_CASE("constraints: normals are compared after the displacement") {
  const PointMatch match{Vec3::Zero(), Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()};
  const auto turned = [](double angle) { return state_of({rotation_of(angle * Vec3::UnitZ()), Vec3::Zero()}); };
  CHECK_FALSE(normals_consistent(match, {}, 0.8));
  CHECK(normals_consistent(match, turned(pi / 2), 1e-3));
  CHECK(normals_consistent(match, turned(pi / 2 - 0.79), 0.8));
  CHECK_FALSE(normals_consistent(match, turned(pi / 2 - 0.81), 0.8));
  CHECK_FALSE(normals_consistent(match, turned(-0.1), 0.8));
}

namespace {

/// Points that are where they belong; others that are matched with points turned by 70 degrees and have normals that
/// nothing makes consistent; and a few whose normals are so as long as those turn the rest along.
std::vector<PointMatch> matches_in_two_layers() {
  Random random(8);
  const auto place = [&] { return Vec3(random.uniform(-10, 10), random.uniform(-10, 10), random.uniform(-10, 10)); };
  const auto turn = [](double angle_deg) { return rotation_of(radians(angle_deg) * Vec3::UnitZ()); };
  std::vector<PointMatch> matches;
  const auto add = [&](int count, const Mat3& moved, const Mat3& normal) {
    for (int k = 0; k < count; ++k) {
      const Vec3 p = place(), n = Vec3(random.normal(), random.normal(), 0).normalized();
      matches.push_back({p, moved * p, n, normal * n});
    }
  };
  add(24, Mat3::Identity(), Mat3::Identity());
  add(12, turn(70), turn(140));
  add(6, turn(40), turn(52));
  return matches;
}

}  // namespace

TEST_CASE("constraints: the displacement is recomputed until no point violates the consistency of normals") {
  const std::vector<PointMatch> matches = matches_in_two_layers();
  const double alpha = radians(45);
  const ConsistentState found = consistent_state(matches, alpha);
  // The first displacement shows the twelve, the second one the six, the third one is that of what is left.
  CHECK(found.solved == 3);
  CHECK(found.count == 24);
  CHECK(std::count(found.valid.begin(), found.valid.begin() + 24, 1) == 24);
  CHECK(rotation_vector(rotation_matrix(found.state)).norm() < 1e-12);
  CHECK(found.state.translation.norm() < 1e-12);
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (found.valid[i]) CHECK(normals_consistent(matches[i], found.state, alpha));

  // Once only would not do: what is left then turns the points by degrees, and violates the constraint itself.
  std::vector<Vec3> p, x;
  for (const PointMatch& m : matches) p.push_back(m.p), x.push_back(m.x);
  const StateVector first = best_state(p, x);
  p.clear(), x.clear();
  std::vector<PointMatch> left;
  for (const PointMatch& m : matches)
    if (normals_consistent(m, first, alpha)) p.push_back(m.p), x.push_back(m.x), left.push_back(m);
  CHECK(left.size() == 30);
  const StateVector once = best_state(p, x);
  CHECK(rotation_vector(rotation_matrix(once)).norm() > radians(3));
  CHECK(std::count_if(left.begin(), left.end(),
                      [&](const PointMatch& m) { return !normals_consistent(m, once, alpha); }) == 6);
}

TEST_CASE("constraints: of fewer than three matches no displacement is made") {
  const std::vector<PointMatch> two(2, {Vec3(1, 2, 3), Vec3(4, 5, 6), Vec3::UnitZ(), Vec3::UnitZ()});
  const ConsistentState found = consistent_state(two, 1);
  CHECK(found.count == 2);
  CHECK(found.solved == 0);
  CHECK(found.state.translation.isZero());
}
