/// Claims about alignment: found from any pose, told, and never silent.
#include "verify/align/align.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "testing/meshes.h"

using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

constexpr double T = 0.1, sigma = 0.02;

VerifyOptions by(AlignBy method) {
  VerifyOptions options;
  options.tolerance = T;
  options.align = method;
  return options;
}

/// A step block: three different lengths, no symmetry.
TriangleMesh block() {
  auto mesh = turned({{0, 0}, {9, 0}, {9, 12}, {5, 12}, {5, 20}, {0, 20}}, 4);  // square prisms: flat faces only
  for (auto& v : mesh.vertices) v = Vec3(1.6 * v.x() + (v.z() > 15 ? 2.0 : 0.0), v.y(), v.z());
  return mesh;
}

Scan moved_scan(Scan scan, const Pose& pose) {
  for (auto& p : scan.cloud.points) p = pose * p;
  return scan;
}

const Pose elsewhere{rotation_of({0.9, -1.4, 0.6}), {40, -25, 310}};

}  // namespace

TEST_CASE("align: a scan in a frame of its own is refused, the hint names the motion, and alignment verifies it") {
  const auto truth = block();
  const auto scan = scanned(truth, 20000, sigma);
  const auto away = moved_scan(scan, elsewhere);
  const auto refused = verdict_on(truth, away, by(AlignBy::none));
  CHECK(refused.verdict == Outcome::out_of_tolerance);
  CHECK(all_reasons(refused).find("give --align best-fit if the frames differ") != std::string::npos);
  CHECK_FALSE(refused.artifacts[0].alignment.has_value());
  for (const auto method : {AlignBy::best_fit, AlignBy::datums}) {
    const auto verdict = verdict_on(truth, away, by(method));
    INFO(name_of(method) << "\n" << all_reasons(verdict));
    CHECK(verdict.verdict == Outcome::verified);
    REQUIRE(verdict.artifacts[0].alignment.has_value());
    const Alignment& a = *verdict.artifacts[0].alignment;
    const Pose back = a.scan_to_artifact * elsewhere;
    CHECK(back.translation.norm() < 0.01);
    CHECK((back.rotation - Mat3::Identity()).norm() < 0.001);
    CHECK(a.rms == Approx(sigma).epsilon(0.2));
    CHECK(write_verdict_json(verdict).find("\"alignment\"") != std::string::npos);
    CHECK(verdict_table(verdict).find("ALIGNED (") != std::string::npos);
    CHECK(verdict_table(verdict).find("after alignment") != std::string::npos);
  }
}

TEST_CASE("align: a damaged part stays refused after it, and no hint promises otherwise") {
  const auto scan = moved_scan(scanned(block(), 20000, sigma), elsewhere);
  auto damaged = block();
  for (auto& v : damaged.vertices)
    if (v.z() > 15) v.z() += 3 * T;
  CHECK(verdict_on(damaged, scan, by(AlignBy::best_fit)).verdict == Outcome::out_of_tolerance);
  CHECK(verdict_on(damaged, scan, by(AlignBy::datums)).verdict == Outcome::out_of_tolerance);
  const auto refused = verdict_on(damaged, scan, by(AlignBy::none));
  CHECK(all_reasons(refused).find("--align") == std::string::npos);
}

TEST_CASE("align: nothing is moved unless it is asked for, also where moving would help") {
  const auto truth = block();
  const auto scan = moved_scan(scanned(truth, 20000, sigma), {Mat3::Identity(), {2 * T, 0, 0}});
  CHECK(verdict_on(truth, scan, by(AlignBy::none)).verdict == Outcome::out_of_tolerance);
}

TEST_CASE("align: of a symmetric part's positions the nearest is taken, and the others are told") {
  const auto truth = box({-20, -10, -5}, {20, 10, 5});
  const auto scan = moved_scan(scanned(truth, 20000, sigma), {rotation_of({0, 0, 0.2}), {1, 2, 3}});
  const auto verdict = verdict_on(truth, scan, by(AlignBy::best_fit));
  CHECK(verdict.verdict == Outcome::verified);
  REQUIRE(verdict.artifacts[0].alignment.has_value());
  CHECK(verdict.artifacts[0].alignment->rotation == Approx(0.2).margin(0.002));
  CHECK(verdict.artifacts[0].alignment->remark.find("3 other positions") != std::string::npos);
}

TEST_CASE("align: a third of the surface unseen and outliers do not lead it astray") {
  const auto truth = block();
  auto scan = scanned(truth, 20000, sigma);
  std::erase_if(scan.cloud.points, [](const Vec3& p) { return p.x() + p.y() < -6; });
  Random random(3);
  for (std::size_t i = 0; i < scan.cloud.size(); i += 100)
    scan.cloud.points[i] += 5 * Vec3(random.normal(), random.normal(), random.normal());
  const auto verdict = verdict_on(truth, moved_scan(scan, elsewhere), by(AlignBy::best_fit));
  INFO(all_reasons(verdict));
  CHECK(verdict.verdict == Outcome::verified);
}

TEST_CASE("align: a part without three flat faces has no datums, and the verdict says so") {
  const auto truth = sphere(20, 60);
  const auto verdict = verdict_on(truth, scanned(truth, 10000, sigma), by(AlignBy::datums));
  CHECK(verdict.verdict == Outcome::cannot_decide);
  CHECK(all_reasons(verdict).find("three flat faces") != std::string::npos);
  CHECK(all_reasons(verdict).find("--align best-fit needs none") != std::string::npos);
}

TEST_CASE("align: a part that lies right stays where it is, however symmetric, and exact meshes too") {
  const auto truth = turned({{0, 0}, {14, 0}, {14, 7}, {0, 7}}, 5);
  for (const double noise : {0.0, sigma}) {
    const auto verdict = verdict_on(truth, scanned(truth, 20000, noise), by(AlignBy::best_fit));
    CHECK(verdict.verdict == Outcome::verified);
    REQUIRE(verdict.artifacts[0].alignment.has_value());
    const Alignment& a = *verdict.artifacts[0].alignment;
    CHECK(a.rotation < 1e-3);
    CHECK(a.translation.norm() < 0.01);
    if (noise == 0) CHECK_FALSE(a.moves());
    if (noise == 0) CHECK(verdict_table(verdict).find("as it should and was not moved") != std::string::npos);
    CHECK(a.remark.find("the nearest to how it lay") != std::string::npos);
  }
}
