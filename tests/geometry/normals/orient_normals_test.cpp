#include "geometry/normals/orient_normals.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "geometry/normals/normals.h"
#include "testing/drilled_block.h"

using namespace partscribe::geometry;
using namespace partscribe::testing;

TEST_CASE("orient normals: two balls and a box face outward though nobody saw from where they were scanned") {
  Context context;
  Random random(31);
  PointCloud cloud;
  std::vector<Vec3> truth;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 d = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    const Vec3 center(i % 2 ? 0.0 : 30.0, 0, 0);
    cloud.points.push_back(center + (8 + 0.02 * random.normal()) * d);
    truth.push_back(d);
  }
  for (int i = 0; i < 6000; ++i) {
    const auto face = static_cast<int>(random.below(6));
    Vec3 p(random.uniform(-6, 6), random.uniform(-6, 6), random.uniform(-6, 6)), n = Vec3::Zero();
    n[face / 2] = face % 2 ? 1 : -1;
    p[face / 2] = 6 * n[face / 2] + 0.02 * random.normal();
    cloud.points.push_back(p + Vec3(0, 40, 0));
    truth.push_back(n);
  }
  estimate_normals(cloud, {}, context);
  CHECK(orient_normals(cloud, 10, context) == 3);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) wrong += cloud.normals[i].dot(truth[i]) < 0;
  CHECK(wrong < 10);
}

TEST_CASE(
    "orient normals: walls of deep holes face into the holes, walls beside them outward, with outliers all about") {
  Context context;
  Random random(77);
  PointCloud cloud;
  std::vector<Vec3> truth;
  const DrilledBlock block{
      {30, 20, 10}, {{-22, -15.4}, {-8, 15.4}, {8, -15.4}, {22, 15.4}}, 4};  // 0.6 mm of wall beside each
  while (cloud.size() < 30000) {
    if (random.uniform() < 0.03) {
      // A mixed pixel, somewhere between a rim and what lies below it.
      const Vec2& h = block.holes[random.below(block.holes.size())];
      const double angle = random.uniform(0, 2 * pi);
      const Vec2 beside = h + (block.radius + random.uniform(-1, 1)) * Vec2(std::cos(angle), std::sin(angle));
      cloud.points.emplace_back(beside.x(), beside.y(), random.uniform(-10, 14));
      truth.emplace_back(0, 0, 0);
    } else {
      const auto place = block.draw(random);
      cloud.points.push_back(place.point + 0.1 * random.normal() * place.normal);
      truth.push_back(place.normal);
    }
  }
  estimate_normals(cloud, {}, context);
  // An outlier a kilometre away.
  cloud.points.emplace_back(1e6, 2e5, 0), cloud.normals.emplace_back(1, 0, 0), cloud.rejected.push_back(0);
  truth.emplace_back(0, 0, 0);
  orient_normals(cloud, 12, context);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) wrong += cloud.normals[i].dot(truth[i]) < -0.3;
  CHECK(wrong < cloud.size() / 100);  // a fifth by the tree alone
  // Another order, another number of threads: the same sense.
  PointCloud other = cloud;
  std::reverse(other.points.begin(), other.points.end()), std::reverse(other.normals.begin(), other.normals.end());
  std::reverse(other.rejected.begin(), other.rejected.end());
  for (Vec3& n : other.normals) n = -n;
  context.threads = 2;
  orient_normals(other, 12, context);
  std::size_t turned = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    turned += !cloud.rejected[i] && other.normals[cloud.size() - 1 - i] != cloud.normals[i];
  CHECK(turned == 0);
}

TEST_CASE("orient normals: the narrow floor of a counterbore faces out of it, though the hole in it was not scanned") {
  Context context;
  Random random(5);
  PointCloud cloud;
  std::vector<Vec3> truth;
  const auto add = [&](const Vec3& p, const Vec3& n) {
    cloud.points.push_back(p + 0.03 * random.normal() * n), truth.push_back(n);
  };
  constexpr double bore = 5.75, hole = 3.4, depth = 7, half = 14, height = 26, per_area = 2;
  const auto many = [&](double area) { return static_cast<int>(per_area * area); };
  for (int i = 0; i < many(4 * half * half); ++i) {
    const double x = random.uniform(-half, half), y = random.uniform(-half, half);
    if (x * x + y * y > bore * bore) add({x, y, 0}, Vec3::UnitZ());
    if (x * x + y * y > hole * hole) add({x, y, -height}, -Vec3::UnitZ());
    add({half, x, -height * (y + half) / (2 * half)}, Vec3::UnitX()),
        add({-half, x, -height * (y + half) / (2 * half)}, -Vec3::UnitX());
    add({x, half, -height * (y + half) / (2 * half)}, Vec3::UnitY()),
        add({x, -half, -height * (y + half) / (2 * half)}, -Vec3::UnitY());
  }
  for (int i = 0; i < many(2 * pi * bore * depth); ++i) {
    const double angle = random.uniform(0, 2 * pi);
    const Vec3 outward(std::cos(angle), std::sin(angle), 0);
    add(bore * outward - random.uniform(0, depth) * Vec3::UnitZ(), -outward);
  }
  const std::size_t floor_begin = cloud.size();
  // Half as dense as elsewhere, for it is seen at a slant.
  for (int i = 0; i < many(0.5 * pi * (bore * bore - hole * hole)); ++i) {
    const double angle = random.uniform(0, 2 * pi), r = std::sqrt(random.uniform(hole * hole, bore * bore));
    add({r * std::cos(angle), r * std::sin(angle), -depth}, Vec3::UnitZ());
  }
  estimate_normals(cloud, {}, context);
  orient_normals(cloud, 12, context);
  std::size_t inward = 0;
  for (std::size_t i = floor_begin; i < cloud.size(); ++i) inward += cloud.normals[i].dot(truth[i]) < -0.5;
  CHECK(inward == 0);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) wrong += cloud.normals[i].dot(truth[i]) < -0.3;
  CHECK(wrong < cloud.size() / 1000);
}

TEST_CASE("orient normals: nothing to do for no points") {
  Context context;
  PointCloud none;
  CHECK(orient_normals(none, 10, context) == 0);
}
