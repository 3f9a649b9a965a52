/// What the borders of views say of their poses, and when they say nothing.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "scan/filter/filter.h"
#include "scan/register/register.h"
#include "scan/register/register_surface.h"
#include "scan/simulate/simulate.h"
#include "testing/registration/cases.h"

using namespace partscribe::scan;
using namespace partscribe::testing::registration;

namespace {

/// Of each view its share in how far those from above stand, on the mean, from those from below.
std::vector<double> shares_of(const SimulatedScan& scan) {
  constexpr double level = 0.2;  // sine of the elevation
  std::vector<double> shares;
  for (const SimulatedView& view : scan.views) {
    const double down = -view.image.world_from_view.rotation(2, 2);
    shares.push_back(down > level ? 1 : down < -level ? -1 : 0);
  }
  const auto above = std::count(shares.begin(), shares.end(), 1), below = std::count(shares.begin(), shares.end(), -1);
  for (double& share : shares) share /= double(share > 0 ? above : below);
  return shares;
}

/// From the world of what was found to the true one, by view 0.
Pose truth_from_found(const SimulatedScan& scan, const Registration& found) {
  return scan.views[0].image.world_from_view * found.views[0].world_from_view.inverse();
}

/// By how much the part came out thicker than it is, mm along z.
double thicker_by(const SimulatedScan& scan, const Registration& found) {
  const Pose back = truth_from_found(scan, found);
  const std::vector<double> shares = shares_of(scan);
  double result = 0;
  for (std::size_t v = 0; v < shares.size(); ++v) {
    const Pose off = back * found.views[v].world_from_view * scan.views[v].image.world_from_view.inverse();
    result += shares[v] * (off * found.center - found.center).z();
  }
  return result;
}

/// As they were measured and filtered, with their guesses.
std::vector<RegisterView> guessed_views(const SimulatedScan& scan, Context& context) {
  std::vector<RangeImage> images;
  for (const SimulatedView& view : scan.views) images.push_back(view.image);
  auto views = views_to_register(scan.merged, images, context);
  for (std::size_t v = 0; v < views.size(); ++v) views[v].guess = scan.views[v].initial_guess;
  return views;
}

}  // namespace

TEST_CASE("register: borders are measured from where noise has not rounded the edge") {
  // Of a block that all views see equally askew only borders tell how far they stand from the middle.
  std::vector<Side> sides;
  for (int k = 0; k < 3; ++k)
    for (const double s : {1.0, -1.0}) sides.push_back({s * Vec3::Unit(k), 14.0 + 3 * k});
  const Surface block = convex(sides, 25);
  Context context;
  context.threads = 2;
  SimulateOptions options = small();
  options.resolution = 128, options.pose_noise_angle = 0.03, options.pose_noise_shift = 0.5, options.sigma = 0.2;
  const SimulatedScan scan = simulate(block, options, context);
  std::vector<Pose> truth;
  for (const SimulatedView& view : scan.views) truth.push_back(view.image.world_from_view);
  const double pixel = scan.views[0].image.pitch_x;
  const Registration found = run(guessed_views(scan, context));
  REQUIRE(count(found, ViewStatus::registered) == 7);
  const Pose back = truth_from_found(scan, found);
  double farther = 0;  // than they stood, on the mean; their directions add up to nothing
  for (std::size_t v = 0; v < truth.size(); ++v) {
    const Vec3 middle = found.center,
               off = back * found.views[v].world_from_view * truth[v].inverse() * middle - middle;
    farther -= off.dot(truth[v].rotation.col(2)) / double(truth.size());
  }
  INFO(farther << " mm, pixel " << pixel);
  CHECK(std::abs(farther) < 0.05 * pixel);
}

TEST_CASE("register: where surfaces fix nothing they do not pull against the borders") {
  // Of a plate each view sees one side and some of the rim: what lies between the sides only borders tell.
  std::vector<Side> sides{{Vec3::UnitZ(), 5}, {-Vec3::UnitZ(), 5}};
  for (int k = 0; k < 7; ++k)
    sides.push_back({Vec3(std::cos(0.9 * k + 0.1 * k * k), std::sin(0.9 * k + 0.1 * k * k), 0), 17.0 + k});
  const Surface plate = convex(sides, 30);
  Context context;
  context.threads = 2;
  double squares = 0, variances = 0, pixel = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SimulateOptions options = small();
    options.resolution = 100, options.sigma = 0.08, options.seed = seed, options.pose_noise_angle = 0.03,
    options.pose_noise_shift = 0.5;
    const SimulatedScan scan = simulate(plate, options, context);
    const Registration found = run(guessed_views(scan, context));
    REQUIRE(count(found, ViewStatus::registered) == 7);
    Eigen::VectorXd across = Eigen::VectorXd::Zero(48);
    const std::vector<double> shares = shares_of(scan);
    for (std::size_t v = 0; v < 8; ++v) across[static_cast<Eigen::Index>(6 * v + 5)] = shares[v];
    squares += std::pow(thicker_by(scan, found), 2), variances += across.dot(found.covariance * across);
    pixel = scan.views[0].image.pitch_x;
  }
  INFO(std::sqrt(squares / 3) << " mm, sigma " << std::sqrt(variances / 3) << ", pixel " << pixel);
  CHECK(std::sqrt(squares / 3) < 0.04 * pixel);
  CHECK(squares < 4 * variances);
  CHECK(std::sqrt(variances / 3) < 0.05 * pixel);
  CHECK(variances < 36 * squares);  // sigma counts on scanners whose borders lie 0.03 pixel out; the simulator's do not
}

TEST_CASE("register: rejected returns inside a face are no border") {
  std::vector<RegisterView> views = scan_of(cut_block(), small(), 0, 0).views;
  Context context;
  const std::size_t before = view_surfaces({views[0]}, 500, context)[0].contour.size();
  PointCloud& cloud = views[0].cloud;
  cloud.rejected.assign(cloud.size(), 0);
  const int side = views[0].width;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const int row = cloud.pixel[i] / side - side / 2, column = cloud.pixel[i] % side - side / 2;
    cloud.rejected[i] = std::abs(row) < 3 && std::abs(column) < 3;
  }
  REQUIRE(std::count(cloud.rejected.begin(), cloud.rejected.end(), 1) == 25);
  REQUIRE(before > 50);
  CHECK(view_surfaces({views[0]}, 500, context)[0].contour.size() <= before);
}

TEST_CASE("register: an edge broken by a narrow chamfer tells nothing of the faces beside it") {
  // Views from above and from below share the sides alone; how far the two ends are apart only borders tell. Those of
  // an end are the inner edges of its chamfers, and the part came out thinner by a chamfer's width, to a twentieth of a
  // pixel. Where enough of the chamfer is seen its own plane tells; else nothing does, and that is said.
  struct Expected {
    double chamfer;  // mm, along either face; a pixel is one
    const char* views;
    bool known;
  };
  const auto [chamfer, arrangement, known] =
      GENERATE(Expected{0, "cube", true}, Expected{1, "cube", false}, Expected{1.25, "12", true});
  std::vector<Side> sides{{Vec3::UnitZ(), 19}, {-Vec3::UnitZ(), 19}};
  for (int k = 0; k < 7; ++k) {
    const double angle = 0.3 + 2 * pi * k / 7 + 0.05 * k * (k % 3), far = 13 + k % 2;
    const Vec3 side(std::cos(angle), std::sin(angle), 0);
    sides.push_back({side, far});
    for (const Vec3& end : {Vec3(0, 0, 1), Vec3(0, 0, -1)})
      sides.push_back({(side + end).normalized(), (far + 19 - chamfer) / std::sqrt(2.0)});
  }
  Context context;
  context.threads = 2;
  SimulateOptions options = small();
  options.views = arrangement, options.resolution = 86, options.pose_noise_angle = 0.03, options.pose_noise_shift = 0.5;
  const SimulatedScan scan = simulate(convex(sides, 24), options, context);
  const double pixel = scan.views[0].image.pitch_x;
  REQUIRE(pixel == Approx(1).margin(0.1));
  const Registration found = run(guessed_views(scan, context));
  REQUIRE(count(found, ViewStatus::refused) == 0);
  const double thicker = thicker_by(scan, found);
  INFO("chamfer " << chamfer << " mm: " << thicker << " mm thicker, pixel " << pixel);
  if (known) CHECK(std::abs(thicker) < 0.05 * pixel);
  const Pose back = truth_from_found(scan, found);
  const bool declared = std::any_of(found.free_motions.begin(), found.free_motions.end(), [&](const FreeMotion& m) {
    return !m.turns && std::abs((back.rotation * m.axis).z()) > 0.99;
  });
  CHECK(declared != known);
}
