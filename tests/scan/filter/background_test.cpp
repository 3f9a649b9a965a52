/// A part is cut out of its surroundings, and only it.
#include "scan/filter/background.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>

#include "core/number.h"
#include "core/random.h"
#include "geometry/points/keep_points.h"

using namespace partscribe::scan;

namespace {

/// A table of 200 x 160 mm at some attitude with a ball (20 mm) and a can (30 mm high) on it, and a wall behind; what
/// each point is of, is told by `of`.
struct Scene {
  PointCloud cloud;
  std::vector<char> of;
};

Scene scene_of(const Pose& attitude, double noise) {
  Scene scene;
  Random random(3);
  const auto add = [&](char what, const Vec3& p, const Vec3& n) {
    scene.cloud.points.push_back(attitude * (p + noise * random.normal() * n));
    scene.cloud.normals.push_back(attitude.rotation * n);
    scene.of.push_back(what);
  };
  for (int i = 0; i < 200; ++i)
    for (int j = 0; j < 160; ++j) add('t', Vec3(i, j, 0), Vec3::UnitZ());
  for (int i = 0; i < 200; ++i)
    for (int j = -40; j < 100; ++j) add('w', Vec3(i, 190, j), -Vec3::UnitY());
  for (int i = 0; i < 6000; ++i) {
    const Vec3 n = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    add('b', Vec3(60, 70, 20) + 20 * n, n);
  }
  for (int i = 0; i < 2500; ++i) {
    const double turn = random.uniform(0, 2 * pi);
    const Vec3 n(std::cos(turn), std::sin(turn), 0);
    add('c', Vec3(140, 90, random.uniform(0, 30)) + 12 * n, n);
  }
  return scene;
}

std::size_t kept_of(const Scene& scene, const Foreground& found, char what) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < scene.of.size(); ++i) count += found.keep[i] && scene.of[i] == what;
  return count;
}

}  // namespace

TEST_CASE("background: one thing on a table is cut out, whatever the attitude") {
  const double noise = 0.2;
  for (const Vec3& turn : {Vec3(0, 0, 0), Vec3(2.5, 0.4, -1)}) {
    const Scene scene = scene_of({rotation_of(turn), Vec3(100, -300, 900)}, noise);
    const auto ball = cut_background(scene.cloud, noise, 1, 1), can = cut_background(scene.cloud, noise, 1, 2);
    REQUIRE(ball.ok());
    REQUIRE(can.ok());
    CHECK(ball->things.size() == 2);
    CHECK(ball->normal.dot(rotation_of(turn) * Vec3::UnitZ()) > 0.9999);
    CHECK(ball->lost < 2.5);
    CHECK(kept_of(scene, *ball, 'b') > 5500);  // all but its lowest 2 mm: a twentieth
    CHECK(kept_of(scene, *can, 'c') > 2200);
    for (const char other : {'t', 'w', 'c'}) CHECK(kept_of(scene, *ball, other) == 0);
    for (const char other : {'t', 'w', 'b'}) CHECK(kept_of(scene, *can, other) == 0);
    PointCloud left = scene.cloud;
    keep_points(left, ball->keep);
    CHECK(left.size() == ball->things[0]);
    CHECK(left.normals.size() == left.size());
    CHECK(left.rays.empty());
  }
}

TEST_CASE(
    "background: what is seen through the plane and under things is counted, for a table hides it and they hide the "
    "table") {
  Scene scene = scene_of({}, 0.2);
  const auto on_table = cut_background(scene.cloud, 0.2, 1, 1);
  REQUIRE(on_table.ok());
  CHECK(on_table->above > 8000);
  CHECK(on_table->behind == 0);
  CHECK(on_table->covered < 0.1 * double(on_table->support));  // the scene's table is seen under its ball
  // The same plane as a face of a slab.
  for (int i = 0; i < 200; ++i)
    for (int j = 0; j < 160; j += 4) {
      scene.cloud.points.push_back(Vec3(i, j, -30));
      scene.cloud.normals.push_back(-Vec3::UnitZ());
    }
  const auto on_slab = cut_background(scene.cloud, 0.2, 1, 1);
  REQUIRE(on_slab.ok());
  CHECK(on_slab->above == on_table->above);
  CHECK(on_slab->behind > 7500);
  CHECK(on_slab->behind <= 8000);
  // The plane as the lowest face of a slab.
  scene.cloud.points.resize(200 * 160), scene.cloud.normals.resize(200 * 160);
  for (int i = 0; i < 200; ++i)
    for (int j = 0; j < 160; ++j) {
      scene.cloud.points.push_back(Vec3(i, j, 30));
      scene.cloud.normals.push_back(Vec3::UnitZ());
    }
  for (int i = 0; i < 200; ++i)
    for (int j = 0; j < 30; ++j) {
      scene.cloud.points.push_back(Vec3(i, 0.5, j));
      scene.cloud.normals.push_back(-Vec3::UnitY());
    }
  const auto lowest = cut_background(scene.cloud, 0.2, 1, 1);
  REQUIRE(lowest.ok());
  CHECK(lowest->behind == 0);
  CHECK(lowest->covered > 0.9 * double(lowest->support));
}

TEST_CASE("background: what is not there is said") {
  const Scene scene = scene_of({}, 0.2);
  const auto third = cut_background(scene.cloud, 0.2, 1, 3);
  REQUIRE_FALSE(third.ok());
  CHECK(third.error().message.find("at least 3 things") != std::string::npos);
  CHECK(third.error().message.find("found 2") != std::string::npos);
  std::vector<std::uint8_t> only_ball;
  for (const char what : scene.of) only_ball.push_back(what == 'b');
  PointCloud ball = scene.cloud;
  keep_points(ball, only_ball);
  const auto alone = cut_background(ball, 0.2, 1, 1);
  CHECK_FALSE(alone.ok());
  CHECK_FALSE(cut_background({}, 0.2, 1, 1).ok());
}
