/// Parts that look alike from several sides: views come to the right one, or it is said that nothing tells.
#include "scan/register/register_alike.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>

#include "core/number.h"
#include "scan/register/register.h"
#include "scan/register/register_pair.h"
#include "scan/simulate/simulate.h"
#include "testing/registration/cases.h"

using namespace partscribe::scan;
using namespace partscribe::testing::registration;

namespace {

/// All views of a part at their true poses, and which of them could stand on other sides.
struct SidesOf {
  explicit SidesOf(const Surface& part)
      : scan(scan_of(part, small(), 0, 0)), surfaces(view_surfaces(scan.views, 1500, context)), all(surfaces.size()) {
    std::iota(all.begin(), all.end(), 0);
  }
  AlikeSides at(const std::vector<Pose>& poses) { return alike_sides(surfaces, poses, all, context); }
  /// Views that are not in any of these, of which there must be two at least, lie as in truth to each other.
  void check_told(const std::vector<Pose>& poses, const std::vector<std::size_t>& open) const {
    std::vector<std::size_t> told;
    std::copy_if(all.begin(), all.end(), std::back_inserter(told),
                 [&](std::size_t v) { return std::find(open.begin(), open.end(), v) == open.end(); });
    REQUIRE(told.size() >= 2);
    const Pose back = scan.truth[told[0]] * poses[told[0]].inverse();
    for (const std::size_t v : told) CHECK(same_place(surfaces[v], back * poses[v], scan.truth[v], 0.05, 1));
  }

  Context context;
  Case scan;
  std::vector<ViewSurface> surfaces;
  std::vector<std::size_t> all;
};

bool about_z(const AlikeTurn& a) {
  return rotation_vector(a.turn.rotation).normalized().cross(Vec3::UnitZ()).norm() < 0.01;
}

}  // namespace

TEST_CASE(
    "register: without any poses a part alike from two sides is put together, and views that show no difference are "
    "named") {
  SimulateOptions scanner;
  scanner.views = "cube", scanner.resolution = 100, scanner.sigma = 0.03, scanner.bit_error = 0.002, scanner.seed = 3;
  const Case scan = scan_of(block_alike_from_two_sides(1), scanner, 0, 0);
  const Registration found = run_from_nothing(scan);
  CHECK(count(found, ViewStatus::refused) == 0);
  CHECK(off_truth(found, scan.truth).angle < 0.01);
  REQUIRE(found.alike.size() == 1);
  CHECK(found.alike[0].angle == Approx(pi).margin(0.01));
  CHECK(found.alike[0].words.find("fit as well turned by 180 degrees about") != std::string::npos);
}

TEST_CASE("register: without any poses a part alike from three sides is put together by all views at once") {
  // Two of three arrangements held against each other at a time leave views a third of a turn round here, or upside
  // down.
  SimulateOptions scanner;
  scanner.views = "cube", scanner.resolution = 140, scanner.sigma = 0.08, scanner.bit_error = 0.002, scanner.seed = 3;
  const Case scan = scan_of(prism_alike_from_sides(3, 2), scanner, 0, 0);
  const Registration found = run_from_nothing(scan);
  CHECK(count(found, ViewStatus::refused) == 0);
  CHECK(off_truth(found, scan.truth).angle < 0.01);
  REQUIRE(found.alike.size() == 2);
  for (const AlikePlaces& places : found.alike) {
    CHECK(places.angle == Approx(2 * pi / 3).margin(0.01));
    CHECK(places.words.find("fit as well turned by 120 degrees about") != std::string::npos);
  }
}

TEST_CASE(
    "register: without any poses views of a part alike from several sides are refused where they slide, or come to lie "
    "upon one another") {
  SimulateOptions scanner;
  scanner.views = "8", scanner.resolution = 80, scanner.sigma = 0.05, scanner.bit_error = 0.002, scanner.seed = 2;
  const Registration sliding = run_from_nothing(scan_of(prism_alike_from_sides(3, 2), scanner, 0, 0));
  scanner.views = "cube", scanner.resolution = 100, scanner.sigma = 0.03, scanner.seed = 3;
  const Registration all_alike = run_from_nothing(scan_of(prism_alike_from_sides(4, 0), scanner, 0, 0));
  for (const Registration& found : {sliding, all_alike}) {
    CHECK(count(found, ViewStatus::refused) == 7);
    CHECK(found.alike.empty());
    CHECK(found.views[7].reason.find("nothing tells which of them each view shows") != std::string::npos);
  }
}

TEST_CASE("register: without any poses no group of views is left half a turn round") {
  SimulateOptions scanner;
  scanner.views = "12", scanner.resolution = 72, scanner.sigma = 0.03, scanner.bit_error = 0.002, scanner.seed = 3;
  const Case scan = scan_of(block_alike_from_two_sides(2), scanner, 0, 0);
  const Registration found = run_from_nothing(scan);
  CHECK(off_truth(found, scan.truth).angle < 0.01);  // refused ones do not count
}

TEST_CASE("register: of views on both sides of a part alike from two sides those that lie on the wrong one are found") {
  SidesOf block(block_alike_from_two_sides(4));
  const std::vector<Pose>& truth = block.scan.truth;
  const AlikeSides right = block.at(truth);
  CHECK(right.better.empty());
  const auto it = std::find_if(right.turns.begin(), right.turns.end(),
                               [](const AlikeTurn& a) { return about_z(a) && !a.open.empty(); });
  const std::vector<std::size_t> open = it == right.turns.end() ? std::vector<std::size_t>() : it->open;
  CHECK(open.size() <= 6);  // all but those from where the corner is seen
  // Whoever tells its side comes back to it.
  for (const std::size_t turned : block.all) {
    if (std::find(open.begin(), open.end(), turned) != open.end()) continue;
    std::vector<Pose> poses = truth;
    poses[turned] = Pose{rotation_of(pi * Vec3::UnitZ()), Vec3::Zero()} * poses[turned];
    poses = block.at(poses).better;
    INFO("view " << turned << " turned");
    REQUIRE(!poses.empty());
    block.check_told(poses, open);
  }
}

TEST_CASE("register: views on three sides of a part alike from three come to one of them together") {
  SidesOf prism(prism_alike_from_sides(3, 4));
  const AlikeSides right = prism.at(prism.scan.truth);
  CHECK(right.better.empty());
  REQUIRE(std::count_if(right.turns.begin(), right.turns.end(), about_z) == 2);
  std::vector<std::size_t> open;
  for (const AlikeTurn& turn : right.turns) open.insert(open.end(), turn.open.begin(), turn.open.end());
  // Every view a third of a turn farther than the one before.
  std::vector<Pose> poses = prism.scan.truth;
  for (const std::size_t v : prism.all)
    poses[v] = Pose{rotation_of(2 * pi / 3 * static_cast<double>(v % 3) * Vec3::UnitZ()), Vec3::Zero()} * poses[v];
  for (int round = 0; round < 4; ++round)  // turns are told by surfaces that lie where they should
    if (AlikeSides sides = prism.at(poses); !sides.better.empty()) poses = std::move(sides.better);
  prism.check_told(poses, open);
}

TEST_CASE(
    "register: a block that nothing turns onto itself is not alike after any turn, and a cylinder only from end to "
    "end") {
  SidesOf cut(cut_block()), round(cylinder());
  const AlikeSides block = cut.at(cut.scan.truth);
  CHECK(!block.any_open());
  CHECK(block.better.empty());
  const AlikeSides ends = round.at(round.scan.truth);
  REQUIRE(ends.turns.size() == 1);
  CHECK((ends.turns[0].turn.rotation * Vec3::UnitZ()).z() < -0.99);
  CHECK(ends.turns[0].open.size() == 8);
}
