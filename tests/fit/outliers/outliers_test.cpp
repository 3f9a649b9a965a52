#include "fit/outliers/outliers.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "model/distance/distance.h"
#include "testing/recovery/cases.h"

using namespace partscribe::fit;
using namespace partscribe::testing::recovery;

namespace {

struct Wall {
  std::vector<Vec3> points, rays;
  std::size_t surface = 0;  ///< the first so many are no outliers

  /// A wall in the plane z = 0, seen from both sides, and outliers around it.
  Wall(double thickness, double sigma, std::size_t count, std::size_t outliers, std::uint64_t seed) : surface(count) {
    Random random(seed);
    for (std::size_t i = 0; i < count + outliers; ++i) {
      const double side = random.uniform() < 0.5 ? -1 : 1;
      const double height = i < count ? side * thickness / 2 + sigma * random.normal() : random.uniform(-10, 10);
      points.emplace_back(random.uniform(-20, 20), random.uniform(-20, 20), height);
      rays.push_back(Vec3(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), -side).normalized());
    }
  }
};

std::size_t outliers_in(const SurfacePoints& found, std::size_t begin, std::size_t end) {
  std::size_t count = 0;
  for (std::size_t i = begin; i < end; ++i) count += found.outlier[i];
  return count;
}

}  // namespace

TEST_CASE("outliers: a wall thinner than its points are apart, seen from both sides, is two surfaces") {
  Context context;
  context.threads = 2;
  const Wall wall(0.6, 0.03, 3200, 160, 4);  // 1 mm apart
  const SurfacePoints found = surface_points_of(wall.points, wall.rays, 0.03, context);
  CHECK(outliers_in(found, 0, wall.surface) < 64);
  CHECK(outliers_in(found, wall.surface, wall.points.size()) > 120);
}

namespace {

/// A square in the plane z = 0, a patch of which is `times` as dense as the rest, the patch first; then outliers.
std::vector<Vec3> patched(std::size_t patch, double times, std::size_t outliers) {
  Random random(6);
  const double width = 20, whole = 100, per_area = double(patch) / (width * width);
  const auto rest = static_cast<std::size_t>(per_area / times * (whole * whole - width * width));
  std::vector<Vec3> points;
  while (points.size() < patch)
    points.emplace_back(random.uniform(0, width), random.uniform(0, width), random.normal());
  while (points.size() < patch + rest) {
    const Vec3 p(random.uniform(-40, 60), random.uniform(-40, 60), random.normal());
    if (p.x() < 0 || p.x() > width || p.y() < 0 || p.y() > width) points.push_back(p);
  }
  for (std::size_t i = 0; i < outliers; ++i)
    points.emplace_back(random.uniform(-40, 60), random.uniform(-40, 60), random.uniform(-50, 50));
  return points;
}

}  // namespace

TEST_CASE(
    "outliers: the densest of a surface are none, though they all lie within what was thought to be noise of one "
    "another") {
  Context context;
  const std::size_t patch = 1200;
  const SurfacePoints found = surface_points_of(patched(patch, 10, 700), {}, 3.2, context);
  CHECK(outliers_in(found, 0, patch) < patch / 20);
  CHECK(found.sigma == Approx(1).epsilon(0.15));
}

TEST_CASE(
    "outliers: noise thought to be several times as wide comes down to what it is, and outliers are found in it") {
  Context context;
  const std::size_t outliers = 900;
  const std::vector<Vec3> points = patched(1200, 10, outliers);
  const SurfacePoints found = surface_points_of(points, {}, 6, context);
  CHECK(outliers_in(found, points.size() - outliers, points.size()) > 2 * outliers / 3);
  CHECK(found.sigma == Approx(1).epsilon(0.15));
}

TEST_CASE("outliers: most are found among a third of them, few points of the surface are taken for one") {
  const Case c = make_case("box", hardest_conditions(), 5);
  Context context;
  const SurfacePoints found = surface_points_of(c.scan.cloud.points, c.scan.cloud.rays, 1.5 * c.noise, context);
  const ModelDistance distance(c.truth);
  const Pose part_from_scan = c.scan_from_part.inverse();
  std::size_t outliers = 0, outliers_found = 0, surface = 0, surface_lost = 0;
  for (std::size_t i = 0; i < c.scan.cloud.size(); ++i) {
    const double d = std::abs(distance(part_from_scan * c.scan.cloud.points[i]).distance);
    if (d > 6 * c.noise) ++outliers, outliers_found += found.outlier[i];
    if (d < 2 * c.noise) ++surface, surface_lost += found.outlier[i];
  }
  CHECK(outliers_found > 0.6 * double(outliers));
  CHECK(surface_lost < 0.06 * double(surface));
  CHECK(found.sigma == Approx(c.noise).epsilon(0.2));
}

TEST_CASE("outliers: a dot of points that stands apart is one heap of them") {
  Random random(11);
  const double sigma = 1;
  std::vector<Vec3> points;
  const auto near = [&](double width) { return Vec3(width * Vec3(random.normal(), random.normal(), random.normal())); };
  for (int i = 0; i < 2500; ++i)
    points.push_back(Vec3(random.uniform(-50, 50), random.uniform(-50, 50), sigma * random.normal()));
  const std::size_t surface = points.size();
  for (int i = 0; i < 120; ++i) points.push_back(Vec3(0, 0, 40) + near(1.8));
  const std::size_t dot = points.size();
  for (int i = 0; i < 700; ++i)
    points.push_back({random.uniform(-70, 70), random.uniform(-70, 70), random.uniform(-70, 70)});
  Context context;
  const SurfacePoints found = surface_points_of(points, {}, sigma, context);
  const auto outliers = [&](std::size_t from, std::size_t to) {
    return std::count(found.outlier.begin() + std::ptrdiff_t(from), found.outlier.begin() + std::ptrdiff_t(to), 1);
  };
  CHECK(outliers(surface, dot) > 110);
  CHECK(outliers(0, surface) < 100);
}
