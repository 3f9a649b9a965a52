/// The experiment of 1993: an object in eight poses, one view after the other, in the frame of the first.
#include "scan/register/as_published/register_as_published.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "scan/register/register_pair.h"
#include "testing/free_forms.h"
#include "testing/registration/cases.h"

using namespace partscribe::scan;
using namespace partscribe::testing;
using namespace partscribe::testing::registration;

namespace {

/// The polyhedron of the experiment, and what its views become.
Case polyhedron_in_eight_poses(std::uint64_t seed) {
  SimulateOptions scanner;
  scanner.resolution = 128, scanner.sigma = 0.02, scanner.seed = seed;
  return scan_in_poses(cut_block(), eight_poses(pi / 4, 0.6), scanner, radians(3), 1);
}

std::vector<Pose> guesses_of(const Case& scan) {
  std::vector<Pose> guesses;
  for (const RegisterView& view : scan.views) guesses.push_back(*view.guess);
  return guesses;
}

StartResult published(const Case& scan, const PaperOptions& options, int threads = 2) {
  Context context;
  context.threads = threads;
  return register_as_published(view_surfaces(scan.views, 1000, context, false), guesses_of(scan), options, context);
}

/// How far the points of the worst view are from where they belong, in the frame of the first view, on the root mean
/// square; pixels.
double worst_view(const Case& scan, const std::vector<Pose>& poses) {
  const Pose back = scan.truth[0] * poses[0].inverse();
  double worst = 0;
  for (std::size_t v = 1; v < poses.size(); ++v) {
    const PointCloud& cloud = scan.views[v].cloud;
    double sum = 0;
    for (const Vec3& p : cloud.points) sum += (back * poses[v] * p - scan.truth[v] * p).squaredNorm();
    const double pixel = std::abs(cloud.points[1].x() - cloud.points[0].x());  // next to each other in a row
    worst = std::max(worst, std::sqrt(sum / double(cloud.size())) / pixel);
  }
  return worst;
}

bool all_placed(const StartResult& found) {
  return std::all_of(found.placed.begin(), found.placed.end(), [](auto p) { return p != 0; });
}

}  // namespace

TEST_CASE("register as published: the polyhedron's eight poses are recovered in all cases, to a quarter of a pixel") {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Case scan = polyhedron_in_eight_poses(seed);
    const StartResult found = published(scan, {});
    INFO("seed " << seed);
    CHECK(all_placed(found));
    CHECK(found.poses[0].translation == scan.views[0].guess->translation);  // the first view is the frame
    CHECK(worst_view(scan, found.poses) < 0.25);
    CHECK(worst_view(scan, guesses_of(scan)) > 2);
  }
}

TEST_CASE("register as published: the eight poses pass the judgement of all views, none is refused") {
  const Case scan = polyhedron_in_eight_poses(1);
  RegisterOptions options;
  options.method = PairMethod::paper;
  const Registration found = run(scan.views, options);
  for (const auto& view : found.views) UNSCOPED_INFO(view.reason);
  CHECK(count(found, ViewStatus::reference) == 1);
  CHECK(found.views[0].status == ViewStatus::reference);
  CHECK(count(found, ViewStatus::registered) == 7);
  CHECK(off_truth(found, scan.truth).angle < radians(0.1));
}

TEST_CASE("register as published: points that no earlier view can see lead a view astray unless they are left out") {
  const Case scan = polyhedron_in_eight_poses(1);
  PaperOptions without;
  without.visibility = false;
  CHECK(worst_view(scan, published(scan, {}).poses) < 0.25);
  const StartResult found = published(scan, without);
  CHECK((!all_placed(found) || worst_view(scan, found.poses) > 2));
}

TEST_CASE("register as published: with a small alpha the eight poses are not recovered, with a large one all are") {
  const Case scan = polyhedron_in_eight_poses(1);
  PaperOptions options;
  for (const double alpha_deg : {20.0, 45.0, 60.0}) {
    options.normal_angle = radians(alpha_deg);
    const StartResult found = published(scan, options);
    INFO("alpha " << alpha_deg);
    CHECK(all_placed(found));
    CHECK(worst_view(scan, found.poses) < 0.25);
  }
  options.normal_angle = radians(1.5);  // half of what the guesses are off
  const StartResult found = published(scan, options);
  CHECK((!all_placed(found) || worst_view(scan, found.poses) > 1));
}

TEST_CASE("register as published: a sculptured part is put together view by view from its triangulations") {
  SimulateOptions scanner;
  scanner.resolution = 128, scanner.sigma = 0.02;
  const auto mesh = sculpture(90);
  const Case scan = scan_in_poses(surface_of(mesh), eight_poses(pi / 6, 0.6), scanner, radians(2), 1);
  const StartResult found = published(scan, free_form_options());
  CHECK(all_placed(found));
  CHECK(worst_view(scan, found.poses) < 1);
  CHECK(worst_view(scan, guesses_of(scan)) > 3);
}

TEST_CASE("register as published: a view whose estimate is far off fails with one line, and the others do not suffer") {
  Case scan = polyhedron_in_eight_poses(2);
  const Vec3 middle = scan.truth[5] * Vec3(scan.truth[5].inverse() * Vec3::Zero());
  const Mat3 turn = rotation_of(1.2 * Vec3(0.3, 0.5, 0.8).normalized());
  scan.views[5].guess = Pose{turn, middle - turn * middle + Vec3(0, 9, 0)} * scan.truth[5];
  RegisterOptions options;
  options.method = PairMethod::paper;
  const Registration found = run(scan.views, options);
  CHECK(found.views[5].status == ViewStatus::refused);
  CHECK(!found.views[5].reason.empty());
  CHECK(found.views[5].reason.find('\n') == std::string::npos);
  CHECK(count(found, ViewStatus::registered) == 6);
  CHECK(off_truth(found, scan.truth).angle < radians(0.5));
}

TEST_CASE("register as published: the same bytes for any number of threads") {
  const Case scan = polyhedron_in_eight_poses(1);
  for (const PaperOptions& options : {PaperOptions{}, free_form_options()}) {
    const StartResult one = published(scan, options, 1), three = published(scan, options, 3);
    for (std::size_t v = 0; v < one.poses.size(); ++v) {
      CHECK(one.poses[v].rotation == three.poses[v].rotation);
      CHECK(one.poses[v].translation == three.poses[v].translation);
    }
  }
}
