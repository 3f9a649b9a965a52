/// Views of known poses are found again, and what cannot be known is said.
#include "scan/register/register.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "core/number.h"
#include "core/random.h"
#include "scan/filter/filter.h"
#include "scan/register/register_joint.h"
#include "scan/register/register_pair.h"
#include "scan/register/register_planes.h"
#include "scan/register/register_start.h"
#include "scan/simulate/simulate.h"
#include "testing/registration/cases.h"

using namespace partscribe::scan;
using namespace partscribe::testing::registration;

namespace {

/// A drum with a small bump in sight from everywhere: a few hundredths of what is seen fix how it is turned.
Surface drum_with_bumps() {
  std::vector<Ball> bumps;
  for (int k = 0; k < 4; ++k) bumps.push_back({Vec3(6 * std::cos(1.7 * k), 6 * std::sin(1.7 * k), 4.0 * k - 7), 6});
  return drum_with(bumps, {13, 13, 15});
}

}  // namespace

TEST_CASE("register: views of a block are found from guesses 3 degrees and 1 mm off") {
  const Case scan = scan_of(cut_block(), small(), 0.05, 1);
  const Registration found = run(scan.views);
  CHECK(count(found, ViewStatus::registered) == 7);
  CHECK(found.free_motions.empty());
  const Off off = off_truth(found, scan.truth);
  const double pixel = scan.views[0].cloud.points.empty() ? 0 : 44 * std::sqrt(3.0) / 72;
  CHECK(off.shift < pixel / 8);
  CHECK(off.angle < 0.2 * pi / 180);
  for (const auto& view : found.views) CHECK(view.overlap > 0.5);
}

TEST_CASE("register: a stated sigma is of the size of the error") {
  double sum = 0, most = 0;
  int n = 0;
  for (std::uint64_t seed : {3, 4, 5}) {
    auto options = small();
    options.seed = seed, options.resolution = 60;
    const Case scan = scan_of(cut_block(), options, 0.03, 0.5);
    const Registration found = run(scan.views);
    const Pose back = scan.truth[0] * found.views[0].world_from_view.inverse();
    for (std::size_t v = 1; v < scan.truth.size(); ++v) {
      const Pose d = back * found.views[v].world_from_view * scan.truth[v].inverse();
      const double z =
          rotation_vector(d.rotation).squaredNorm() / found.views[v].covariance.topLeftCorner<3, 3>().trace();
      sum += z, most = std::max(most, z), ++n;
    }
  }
  CHECK(sum / n > 0.1);
  CHECK(sum / n < 6);
  CHECK(most < 30);
}

TEST_CASE("register: without any poses the features do, or it is refused") {
  auto options = small();
  options.resolution = 120, options.views = "24";
  Case scan = scan_of(balls(), options, 0, 0);
  scan.views.resize(6), scan.truth.resize(6);
  const Registration found = run_from_nothing(scan);
  for (const auto& view : found.views) UNSCOPED_INFO(view.reason << view.overlap);
  CHECK(count(found, ViewStatus::registered) == 5);
  CHECK(off_truth(found, scan.truth).angle < 0.5 * pi / 180);

  // Views across the edges of a block share few faces, and faces are all alike.
  options.resolution = 40, options.views = "octahedron";
  const Case block = scan_of(cut_block(), options, 0, 0);
  const Registration doubtful = run_from_nothing(block);
  CHECK(off_truth(doubtful, block.truth).angle < 1 * pi / 180);
}

TEST_CASE("register: without any poses a block is put together by its planes") {
  auto options = small();
  options.resolution = 90;
  const Case block = scan_of(plain_block(), options, 0, 0);
  const Registration found = run_from_nothing(block);
  for (const auto& view : found.views) UNSCOPED_INFO(view.reason);
  CHECK(count(found, ViewStatus::registered) >= 5);
  CHECK(off_truth(found, block.truth).angle < 0.5 * pi / 180);
}

TEST_CASE("register: without any poses a face laid on a wrong face is put right once all views are there") {
  auto options = small();
  options.resolution = 60, options.views = "8";
  const Case block = scan_of(plain_block(), options, 0, 0);
  const Registration found = run_from_nothing(block);
  for (const auto& view : found.views) UNSCOPED_INFO(view.reason);
  CHECK(count(found, ViewStatus::registered) >= 6);
  CHECK(off_truth(found, block.truth).angle < 1 * pi / 180);
}

TEST_CASE("register: without any poses a view that few others laid half a turn round is put right by all of them") {
  SimulateOptions scanner;
  scanner.views = "cube", scanner.resolution = 60, scanner.sigma = 0.08, scanner.bit_error = 0.002, scanner.seed = 3;
  const Case scan = scan_of(cut_block(), scanner, 0, 0);
  const Registration found = run_from_nothing(scan);
  CHECK(count(found, ViewStatus::refused) == 0);
  const Off off = off_truth(found, scan.truth);
  CHECK(off.angle < 0.01);
  CHECK(off.shift < 0.3);
}

TEST_CASE("register: without any poses a view that may slide and turn is refused, wherever it lies") {
  SimulateOptions scanner;
  scanner.views = "12", scanner.resolution = 60, scanner.sigma = 0.02, scanner.bit_error = 0.002, scanner.seed = 3;
  const Case scan = scan_of(plain_block(), scanner, 0, 0);
  const Registration found = run_from_nothing(scan);
  CHECK(count(found, ViewStatus::refused) < 4);
  for (std::size_t v = 0; v < scan.views.size(); ++v) {
    INFO("view " << v << ": " << found.views[v].reason);
    const auto own = std::count_if(found.free_motions.begin(), found.free_motions.end(), [&](const FreeMotion& m) {
      return std::count(m.views.begin(), m.views.end(), v) > 0;
    });
    CHECK((found.views[v].status == ViewStatus::refused || own < 2));
  }
  CHECK(off_truth(found, scan.truth).angle < 0.02);
}

TEST_CASE("register: beside creases views do not contradict each other at their true poses, and another face does") {
  // Faces five pixels wide, seen at a slant: half of what two views share lies beside a crease.
  const Case scan = scan_of(cut_block(), small(), 0, 0);
  Context context;
  const auto surfaces = view_surfaces(scan.views, 1500, context);
  std::vector<std::size_t> all(surfaces.size());
  std::iota(all.begin(), all.end(), 0);
  const double reach = confirm_reach(surfaces);
  for (const std::size_t v : all) {
    CHECK(agreement(surfaces, scan.truth, v, scan.truth[v], all, reach, 1500, Creases::left_out).disagreement() <
          0.005);
    const Vec3 middle = scan.truth[v] * surfaces[v].center;
    const Mat3 turn = rotation_of(0.5 * Vec3(1, 1, 1).normalized());
    const Pose turned = Pose{turn, middle - turn * middle} * scan.truth[v];
    CHECK(agreement(surfaces, scan.truth, v, turned, all, reach, 1500, Creases::left_out).disagreement() > 0.1);
  }
}

TEST_CASE("register: planes of a view are its faces, and lay one view onto another") {
  auto options = small();
  options.bit_error = 0;
  const Case block = scan_of(cut_block(), options, 0, 0);
  Context context;
  const std::vector<ViewSurface> surfaces = view_surfaces(block.views, 1000, context);
  const std::vector<ViewPlane> first = planes_of(surfaces[0], 12);
  REQUIRE(first.size() >= 3);
  // Each is a face of the block: its distance from the block's middle is one of those that it was made with.
  for (const ViewPlane& plane : first) {
    const double from_middle = plane.offset + (block.truth[0].rotation * plane.normal).dot(block.truth[0].translation);
    const auto faces = {14.0, 17.0, 20.0, 20.0, 19.0, 22.0, 18.0, 21.0, 20.5, 23.0, 19.5};
    CHECK(std::any_of(faces.begin(), faces.end(), [&](double d) { return std::abs(from_middle - d) < 0.05; }));
  }
  // The view beside it shares two faces at least; one of the poses is near enough to start from.
  std::size_t beside = 1;
  for (std::size_t v = 1; v < block.truth.size(); ++v)
    if (block.truth[v].rotation.col(2).dot(block.truth[0].rotation.col(2)) >
        block.truth[beside].rotation.col(2).dot(block.truth[0].rotation.col(2)))
      beside = v;
  const auto poses = plane_poses(planes_of(surfaces[beside], 12), first, surfaces, beside, 0, 0.2, 16);
  const Pose truth = block.truth[0].inverse() * block.truth[beside];
  CHECK(std::any_of(poses.begin(), poses.end(), [&](const Pose& p) {
    return rotation_vector(truth.rotation.transpose() * p.rotation).norm() < 0.05 &&
           (p * surfaces[beside].center - truth * surfaces[beside].center).norm() < 0.2 * surfaces[beside].radius;
  }));
}

TEST_CASE("register: a cylinder turns about its axis, and that is said") {
  auto options = small();
  options.resolution = 56;
  const Case scan = scan_of(cylinder(), options, 0.05, 0.5);
  const Registration found = run(scan.views);
  REQUIRE(found.free_motions.size() >= 1);
  const auto turning =
      std::find_if(found.free_motions.begin(), found.free_motions.end(), [](const FreeMotion& m) { return m.turns; });
  REQUIRE(turning != found.free_motions.end());
  CHECK(turning->views.size() == 7);
  CHECK(turning->words.find("turn about") != std::string::npos);
  // In the frame of the reference view's guess the axis is z within that guess's error.
  CHECK(std::abs(turning->axis.z()) > 0.99);
  CHECK(found.warnings.size() >= 1);
  // Together the seven may turn by a fiftieth of the part's size; what each is fixed to does not count that.
  Eigen::VectorXd turn = Eigen::VectorXd::Zero(48);
  for (const std::size_t v : turning->views) turn.segment<3>(static_cast<Eigen::Index>(6 * v)) = turning->axis / 7;
  const double sigma = std::sqrt(turn.dot(found.covariance * turn));
  CHECK(sigma > 0.01);
  CHECK(sigma < 0.05);
  for (const std::size_t v : turning->views) {
    const Mat3 own = found.views[v].covariance.topLeftCorner<3, 3>();
    CHECK(turning->axis.dot(own * turning->axis) < 0.25 * sigma * sigma);
  }
}

TEST_CASE("register: small bumps fix how a drum is turned") {
  const Case scan = scan_of(drum_with_bumps(), small(), 0.05, 0.5);
  const Registration found = run(scan.views);
  CHECK(count(found, ViewStatus::registered) == 7);
  CHECK(found.free_motions.empty());
  const Off off = off_truth(found, scan.truth);
  CHECK(off.angle < 0.5 * pi / 180);
  CHECK(off.shift < 0.2);  // a quarter of a pixel
}

TEST_CASE("register: views come out truer from filtered images") {
  // Planes through windows of round faces lie inside them, by more the more slanted they are seen.
  SimulateOptions options = small();
  options.resolution = 128, options.sigma = 0.05, options.pose_noise_angle = 0.05, options.pose_noise_shift = 1;
  Context context;
  context.threads = 2;
  const SimulatedScan scan = simulate(drum_with_bumps(), options, context);
  std::vector<RangeImage> images;
  std::vector<Pose> truth;
  for (const SimulatedView& view : scan.views)
    images.push_back(view.image), truth.push_back(view.image.world_from_view);
  const auto with_guesses = [&](std::vector<RegisterView> views) {
    for (std::size_t v = 0; v < views.size(); ++v) views[v].guess = scan.views[v].initial_guess;
    return views;
  };
  const Registration measured = run(with_guesses(views_of(scan.merged)));
  const Registration filtered = run(with_guesses(views_to_register(scan.merged, images, context)));
  REQUIRE(count(filtered, ViewStatus::registered) == 7);
  REQUIRE(count(measured, ViewStatus::registered) == 7);
  INFO(off_truth(measured, truth).angle << " " << off_truth(filtered, truth).angle);
  CHECK(off_truth(filtered, truth).angle < 0.6 * off_truth(measured, truth).angle);
  CHECK(off_truth(filtered, truth).shift < 0.1);
}

TEST_CASE("register: the surface of a filtered view is the same whether its borders are looked for or not") {
  SimulateOptions options = small();
  options.sigma = 0.05;
  Context context;
  const SimulatedScan scan = simulate(drum_with_bumps(), options, context);
  std::vector<RangeImage> images;
  for (const SimulatedView& view : scan.views) images.push_back(view.image);
  const auto views = views_to_register(scan.merged, images, context);
  const auto with = view_surfaces(views, 800, context, true), without = view_surfaces(views, 800, context, false);
  for (std::size_t v = 0; v < views.size(); ++v) {
    CHECK((!with[v].contour.empty() && without[v].contour.empty()));
    CHECK((with[v].points == without[v].points && with[v].measured == without[v].measured &&
           with[v].normals == without[v].normals));
    CHECK((with[v].smooth == without[v].smooth && with[v].variance == without[v].variance &&
           with[v].pixels == without[v].pixels));
    CHECK((with[v].samples == without[v].samples && with[v].raster.depth == without[v].raster.depth));
    CHECK((with[v].sigma == without[v].sigma && with[v].spacing == without[v].spacing &&
           with[v].rejected == without[v].rejected));
  }
}

TEST_CASE("register: places as measured mend what the filter does where surfaces bend") {
  // Filtered places beside creases and the limb lie off by part of the noise, all to one side; measured ones do not.
  Context context;
  context.threads = 2;
  double with = 0, without = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SimulateOptions options = small();
    options.resolution = 128, options.sigma = 0.05, options.seed = seed, options.pose_noise_angle = 0.02,
    options.pose_noise_shift = 0.3;
    const SimulatedScan scan = simulate(drum_with_bumps(), options, context);
    std::vector<RangeImage> images;
    std::vector<Pose> truth;
    for (const SimulatedView& view : scan.views)
      images.push_back(view.image), truth.push_back(view.image.world_from_view);
    auto views = views_to_register(scan.merged, images, context);
    for (std::size_t v = 0; v < views.size(); ++v) views[v].guess = scan.views[v].initial_guess;
    const auto off = [&] {
      const Registration found = run(views);
      REQUIRE(count(found, ViewStatus::registered) == 7);
      return off_truth(found, truth).shift;
    };
    with += off();
    for (RegisterView& view : views) view.measured.clear();
    without += off();
  }
  INFO(with / 3 << " mm, without " << without / 3);
  CHECK(with < 0.7 * without);
}

TEST_CASE("register: a view that others which are refused had led astray is placed after all") {
  SimulateOptions options = small();
  options.views = "8";
  const Case scan = scan_of(plain_block(), options, 0.1, 5);
  const Registration found = run(scan.views);
  CHECK(count(found, ViewStatus::registered) == 7);
  CHECK(off_truth(found, scan.truth).angle < 0.005);
  for (const RegisteredView& view : found.views) CHECK(view.reason.empty());
}

TEST_CASE("register: a view of another part is refused") {
  auto options = small();
  options.resolution = 60;
  Case scan = scan_of(cut_block(), options, 0.03, 0.5);
  auto other = scan_of(cylinder(), options, 0, 0);
  scan.views[5].cloud = other.views[5].cloud;
  const Registration found = run(scan.views);
  CHECK(found.views[5].status == ViewStatus::refused);
  CHECK(!found.views[5].reason.empty());
  CHECK(count(found, ViewStatus::registered) == 6);
  CHECK(off_truth(found, scan.truth).angle < 0.3 * pi / 180);
}

TEST_CASE(
    "register: two views of balls of different radius are no pair, although a cap of one nearly lies on the other") {
  const auto options = small();
  const Case one = scan_of(ball(20), options, 0, 0);
  for (const double radius : {20.0, 22.0}) {
    const Case other = scan_of(ball(radius), options, 0, 0);
    std::vector<RegisterView> pair{one.views[0], other.views[4]};
    pair[0].guess = one.truth[0], pair[1].guess = one.truth[4];
    const Registration found = run(pair);
    INFO(radius << " " << found.views[1].reason << " free " << found.free_motions.size());
    CHECK((found.views[1].status == ViewStatus::refused) == (radius != 20));
  }
}

TEST_CASE("register: the middle about which a cap may turn is told by where its surface lies, not by noisy normals") {
  auto options = small();
  for (const std::uint64_t seed : {1, 2, 3}) {
    options.seed = seed;
    const Case scan = scan_of(ball(20), options, 0, 0);
    std::vector<RegisterView> pair{scan.views[0], scan.views[4]};
    pair[0].guess = scan.truth[0], pair[1].guess = scan.truth[4];
    const Registration found = run(pair);
    INFO(seed << " " << found.views[1].reason);
    REQUIRE(found.free_motions.size() == 3);
    for (const FreeMotion& motion : found.free_motions) {
      CHECK(motion.turns);
      INFO(motion.words);
      CHECK(motion.point.norm() < 0.1);
    }
  }
}

TEST_CASE("register: a start that is a quarter turn off is refused or put right, never wrong") {
  auto options = small();
  options.resolution = 60;
  Case scan = scan_of(cut_block(), options, 0.02, 0.3);
  const Mat3 turn = rotation_of(Vec3(0.2, 0.4, 1).normalized() * 1.5);
  scan.views[3].guess = Pose{turn, Vec3::Zero()} * *scan.views[3].guess;
  const Registration found = run(scan.views);
  CHECK(found.views[3].status == ViewStatus::refused);
  CHECK(off_truth(found, scan.truth).angle < 0.3 * pi / 180);
}

namespace {

/// What is left of a rotation error once turns about a declared axis are taken out; nothing if all turns are declared.
double undeclared_angle(const Mat3& error, const std::vector<FreeMotion>& free) {
  const Eigen::Quaterniond q(error);
  double left = rotation_vector(error).norm();
  int turns = 0;
  for (const FreeMotion& motion : free) {
    if (!motion.turns) continue;
    ++turns;
    left = std::min(left, 2 * std::acos(std::min(1.0, std::hypot(q.w(), q.vec().dot(motion.axis)))));
  }
  return turns >= 3 ? 0 : left;
}

}  // namespace

TEST_CASE("register: a pair of views of a box from 60 degrees off is right, or its freedom is said, or it is refused") {
  std::vector<Side> sides;
  for (int k = 0; k < 3; ++k)
    for (const double s : {1.0, -1.0}) sides.push_back({s * Vec3::Unit(k), 12.0 + 6 * k});
  auto options = small();
  options.views = "16", options.resolution = 64, options.sigma = 0.03;
  const Case scan = scan_of(convex(sides, 24), options, 0, 0);
  Random random(11);
  int placed = 0;
  for (const auto& [a, b] : {std::pair<std::size_t, std::size_t>{9, 14}, {5, 13}, {1, 6}, {3, 8}}) {
    std::vector<RegisterView> pair{scan.views[a], scan.views[b]};
    pair[0].guess = scan.truth[a];
    const Mat3 turn = rotation_of(pi / 3 * Vec3(random.normal(), random.normal(), random.normal()).normalized());
    pair[1].guess = Pose{turn, Vec3::Zero()} * scan.truth[b];
    RegisterOptions wide;
    wide.guess_angle = pi / 3 + 0.1;
    const Registration found = run(pair, wide);
    if (found.views[1].status == ViewStatus::refused) {
      CHECK(!found.views[1].reason.empty());
      continue;
    }
    ++placed;
    const Mat3 error = found.views[1].world_from_view.rotation * scan.truth[b].rotation.transpose();
    INFO(a << " " << b << ": " << rotation_vector(error).norm() * 180 / pi << " degrees");
    CHECK(undeclared_angle(error, found.free_motions) < 1 * pi / 180);
  }
  CHECK(placed >= 1);
}

namespace {

/// Two views of a block that nothing turns onto itself, the second from so many degrees off.
std::vector<RegisterView> block_pair(const Case& scan, double degrees, const Vec3& axis) {
  std::vector<RegisterView> pair{scan.views[0], scan.views[1]};
  const Mat3 turn = rotation_of(degrees * pi / 180 * axis.normalized());
  pair[0].guess = scan.truth[0], pair[1].guess = Pose{turn, Vec3(0.5, -0.5, 0.3)} * scan.truth[1];
  return pair;
}

RegisterOptions within(double degrees) {
  RegisterOptions options;
  options.guess_angle = degrees * pi / 180 + 0.1;
  return options;
}

}  // namespace

TEST_CASE("register: a pair of views comes to one place from wherever it starts") {
  auto options = small();
  options.resolution = 96;
  const Case scan = scan_of(cut_block(), options, 0, 0);
  std::vector<Pose> found;
  for (const double degrees : {5.0, 15.0, 30.0})
    for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 1), Vec3(-1, 1, -1)}) {
      INFO(degrees << " degrees about " << axis.transpose());
      const Registration result = run(block_pair(scan, degrees, axis), within(degrees));
      REQUIRE(result.views[1].status == ViewStatus::registered);
      CHECK(off_truth(result, {scan.truth[0], scan.truth[1]}).angle < 0.3 * pi / 180);
      found.push_back(result.views[1].world_from_view);
    }
  for (const Pose& pose : found)
    CHECK(rotation_vector(found[0].rotation.transpose() * pose.rotation).norm() < 0.03 * pi / 180);
}

TEST_CASE("register: a pair of views far off has the same bytes for any number of threads") {
  auto options = small();
  options.resolution = 48;
  const Case scan = scan_of(cut_block(), options, 0, 0);
  const auto pair = block_pair(scan, 25, {1, 2, 3});
  const Registration one = run(pair, within(25), 1), three = run(pair, within(25), 3);
  CHECK(one.views[1].world_from_view.rotation == three.views[1].world_from_view.rotation);
  CHECK(one.views[1].world_from_view.translation == three.views[1].world_from_view.translation);
  CHECK(one.views[1].covariance == three.views[1].covariance);
}

TEST_CASE("register: what a free motion would displace floats, and what it leaves alone does not") {
  Registration registration;
  registration.views.resize(3);
  for (auto& view : registration.views) view.status = ViewStatus::registered;
  FreeMotion slide;
  slide.views = {1}, slide.axis = Vec3::UnitZ();
  registration.free_motions = {slide};
  PointCloud cloud;
  for (const std::int32_t view : {0, 1, 2})
    for (const Vec3& normal : {Vec3(1, 0, 0), Vec3(0, 0, 1)})
      cloud.points.push_back({3, 2, 1}), cloud.normals.push_back(normal), cloud.view.push_back(view);
  CHECK(floating_points(registration, cloud, 1) == std::vector<std::uint8_t>{0, 0, 0, 1, 0, 0});
  // Two of three that slide together: the third may as well have slid.
  registration.free_motions[0].views = {1, 2};
  CHECK(floating_points(registration, cloud, 1) == std::vector<std::uint8_t>{0, 1, 0, 0, 0, 0});
  // About an axis, a wall that is round about it stays.
  registration.free_motions[0].views = {1}, registration.free_motions[0].turns = true;
  cloud.normals[2] = Vec3(3, 2, 0).normalized();
  CHECK(floating_points(registration, cloud, 1) == std::vector<std::uint8_t>{0, 0, 0, 0, 0, 0});
  cloud.normals[3] = Vec3(1, 0, 0);
  CHECK(floating_points(registration, cloud, 1) == std::vector<std::uint8_t>{0, 0, 0, 1, 0, 0});
  // A face that nobody else saw is all there is.
  cloud.points[3] = {3, 2, 9};
  CHECK(floating_points(registration, cloud, 1) == std::vector<std::uint8_t>{0, 0, 0, 0, 0, 0});
}

TEST_CASE("register: the same bytes for any number of threads") {
  auto options = small();
  options.resolution = 40, options.views = "octahedron";
  const Case scan = scan_of(cut_block(), options, 0.03, 0.5);
  const Registration one = run(scan.views, {}, 1), three = run(scan.views, {}, 3);
  for (std::size_t v = 0; v < one.views.size(); ++v) {
    CHECK(one.views[v].world_from_view.rotation == three.views[v].world_from_view.rotation);
    CHECK(one.views[v].world_from_view.translation == three.views[v].world_from_view.translation);
    CHECK(one.views[v].covariance == three.views[v].covariance);
  }
}

TEST_CASE("register: views are taken apart and put together again") {
  auto options = small();
  options.resolution = 32, options.views = "tetrahedron";
  Context context;
  SimulatedScan scan = simulate(cut_block(), options, context);
  const auto views = views_of(scan.merged);
  REQUIRE(views.size() == 4);
  Registration registration;
  const Pose moved{rotation_of(Vec3(0.1, 0.2, 0.3)), Vec3(5, 6, 7)};
  for (const auto& view : views) {
    registration.views.emplace_back();
    registration.views.back().world_from_view = moved * *view.guess,
    registration.views.back().status = ViewStatus::registered;
  }
  registration.views[2].status = ViewStatus::refused;
  const PointCloud before = scan.merged.cloud;
  place_views(registration, scan.merged);
  const PointCloud& after = scan.merged.cloud;
  std::size_t k = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (before.view[i] == 2) continue;
    REQUIRE((after.points[k] - moved * before.points[i]).norm() < 1e-9);
    REQUIRE(after.view[k] == before.view[i]);
    ++k;
  }
  CHECK(after.size() == k);
  CHECK(after.rays.size() == k);
}

TEST_CASE("register: a screw between poses keeps its axis") {
  const Vec3 on_axis(3, 1, 0), axis = Vec3(0.2, 0.3, 0.9).normalized();
  const Mat3 r = rotation_of(1.2 * axis);
  const Pose b{r, on_axis - r * on_axis + 2 * axis};
  const Pose half = between({}, b, 0.5);
  CHECK(((half * on_axis) - (on_axis + axis)).norm() < 1e-12);
  CHECK((between({}, b, 1).translation - b.translation).norm() < 1e-12);
}

TEST_CASE("register: bad_requests say what was expected") {
  Context context;
  RegisterView view;
  view.name = "a.ply", view.cloud.points.assign(100, Vec3(1, 2, 3));
  auto missing = register_views({view}, {}, context);
  REQUIRE(!missing.ok());
  CHECK(missing.error().message.find("a.ply") != std::string::npos);
  CHECK(missing.error().kind == ErrorKind::usage);
  CHECK(!register_views({}, {}, context).ok());
  view.guess = Pose{}, view.cloud.points[7].x() = std::nan("");
  CHECK(!register_views({view}, {}, context).ok());
}
