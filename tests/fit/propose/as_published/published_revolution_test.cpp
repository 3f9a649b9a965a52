/// Sections across an assumed axis against turned parts whose axis and profile are known.
#include "fit/propose/as_published/published_revolution.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/number.h"
#include "core/random.h"

using namespace partscribe::fit;

namespace {

using Radius = std::function<double(double)>;

const Pose scan_from_turned{rotation_of(Vec3(0.7, -0.4, 0.2)), Vec3(30, -12, 50)};
constexpr double turned_height = 60;  // from -30 to 30 along its axis

double vase_radius(double z) { return 16 + 4 * std::sin(z / 11) + 0.06 * z; }

/// Points of a turned surface, `turn` radians of it seen.
std::vector<Vec3> turned_points(const Radius& radius, double noise, double turn, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3> points;
  for (int i = 0; i < 12000; ++i) {
    const double z = random.uniform(-30, 30), angle = random.uniform(0, turn), r = radius(z);
    const double slope = (radius(z + 1e-4) - radius(z - 1e-4)) / 2e-4;
    const Vec3 out(std::cos(angle), std::sin(angle), 0), normal = (out - slope * Vec3::UnitZ()).normalized();
    points.push_back(scan_from_turned * (r * out + z * Vec3::UnitZ() + noise * random.normal() * normal));
  }
  return points;
}

/// The axis as somebody assumes it: turned by so many degrees about the part's middle, and shifted by so many mm.
struct AssumedAxis {
  Vec3 point, direction;
};
AssumedAxis assumed(double tilt_deg, double shift) {
  const Vec3 x = scan_from_turned.rotation.col(0), z = scan_from_turned.rotation.col(2);
  return {scan_from_turned.translation + shift * Vec3(0.6 * x + 0.8 * scan_from_turned.rotation.col(1)),
          rotation_of(radians(tilt_deg) * (x + 0.5 * scan_from_turned.rotation.col(1)).normalized()) * z};
}

double tilt_of(const Vec3& direction) {
  return degrees(std::asin(direction.cross(scan_from_turned.rotation.col(2)).norm()));
}
/// mm between the true axis and a place of the other one at a height.
double beside(const PublishedRevolution& found, double height) {
  const Vec3 p = scan_from_turned.inverse() * (found.point + height * found.direction);
  return p.head<2>().norm();
}

/// mm, the farthest that a profile is from the true radius, away from its ends.
double profile_off(const PublishedRevolution& found, const Radius& radius) {
  double worst = 0;
  const double middle = (scan_from_turned.inverse() * found.point).z();
  for (int i = 2; i <= 98; ++i) {
    const Vec2 p = found.profile.at(i / 100.0);
    worst = std::max(worst, std::abs(p.x() - radius(middle + p.y())));
  }
  return worst;
}

}  // namespace

TEST_CASE("published revolution: conics across a wrong axis give axis and profile to a fraction of the noise") {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto points = turned_points(vase_radius, 0.1, 2 * pi, seed);
    const AssumedAxis start = assumed(6, 2);
    REQUIRE(tilt_of(start.direction) == Approx(6).margin(1e-6));
    const auto found = published_revolution(points, start.point, start.direction, {});
    REQUIRE(found);
    INFO("seed " << seed << ", rounds " << found->rounds);
    CHECK(tilt_of(found->direction) < 0.02);
    CHECK(beside(*found, 0) < 0.01);
    CHECK(beside(*found, turned_height / 2) < 0.015);
    CHECK(profile_off(*found, vase_radius) < 0.06);
    CHECK(found->profile_error < 0.1);
    CHECK(found->profile.t.degree == 3);
    CHECK(found->profile.points.size() < found->sections.size() / 2);
  }
}

TEST_CASE("published revolution: without noise it is exact, and the sections are circles") {
  const auto points = turned_points(vase_radius, 0, 2 * pi, 5);
  const AssumedAxis start = assumed(8, 3);
  const auto found = published_revolution(points, start.point, start.direction, {.sections = 120, .tolerance = 0.01});
  REQUIRE(found);
  CHECK(tilt_of(found->direction) < 1e-3);
  CHECK(beside(*found, 0) < 1e-3);
  CHECK(profile_off(*found, vase_radius) < 0.01);
  const auto once = published_revolution(points, start.point, start.direction, {.sections = 120, .rounds = 1});
  REQUIRE(once);
  CHECK(tilt_of(once->direction) > 10 * tilt_of(found->direction));
  for (const ConicSection& s : found->sections) CHECK(s.conic.shorter > 0.999 * s.conic.longer);
}

TEST_CASE("published revolution: half of the turn seen is enough") {
  const auto points = turned_points(vase_radius, 0.05, pi, 4);
  const AssumedAxis start = assumed(5, 1);
  const auto found = published_revolution(points, start.point, start.direction, {});
  REQUIRE(found);
  CHECK(tilt_of(found->direction) < 0.1);
  CHECK(beside(*found, 0) < 0.1);
  CHECK(profile_off(*found, vase_radius) < 0.15);
}

TEST_CASE("published revolution: where the radius grows fast the centres stand beside the axis, and it is found") {
  // r r' = 3 z: the line through the centres leaves a tilt four times as large as the true one, to the other side.
  const Radius horn = [](double z) { return std::sqrt(100 + 3 * z * z); };
  const auto points = turned_points(horn, 0.05, 2 * pi, 6);
  const AssumedAxis start = assumed(4, 1);
  const auto found = published_revolution(points, start.point, start.direction, {});
  REQUIRE(found);
  CHECK(tilt_of(found->direction) < 0.02);
  CHECK(profile_off(*found, horn) < 0.12);
}

TEST_CASE("published revolution: a step and a collar leave the axis where it is") {
  const Radius pin = [](double z) { return z < -5 ? 20.0 : z > 15 && z < 20 ? 14.0 : 10.0; };
  const auto points = turned_points(pin, 0.05, 2 * pi, 7);
  const AssumedAxis start = assumed(3, 1);
  const auto found = published_revolution(points, start.point, start.direction, {});
  REQUIRE(found);
  CHECK(tilt_of(found->direction) < 0.02);
  CHECK(beside(*found, 0) < 0.02);
}

TEST_CASE("published revolution: bad_points and a ball say what was expected") {
  const Radius ball = [](double z) { return std::sqrt(32.0 * 32 - z * z); };
  const auto round = turned_points(ball, 0.01, 2 * pi, 8);
  const AssumedAxis start = assumed(3, 0);
  const auto none = published_revolution(round, start.point, start.direction, {});
  REQUIRE(!none);
  CHECK(none.error().message.find("tell no axis") != std::string::npos);
  std::vector<Vec3> few(round.begin(), round.begin() + 30);
  const auto scarce = published_revolution(few, start.point, start.direction, {});
  REQUIRE(!scarce);
  CHECK(scarce.error().message == "expected at least 5 sections across the assumed axis that are ellipses, found 0");
  CHECK(published_revolution({}, start.point, start.direction, {}).error().message ==
        "expected points of a turned part, found none");
}
