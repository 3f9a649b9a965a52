#include "geometry/normals/normals.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>

#include "core/random.h"
#include "core/statistics.h"
#include "geometry/normals/local_noise.h"
#include "geometry/points/thin.h"

using namespace partscribe::geometry;

namespace {

Vec3 on_sphere(Random& random) {
  Vec3 v(random.normal(), random.normal(), random.normal());
  return v.normalized();
}

/// A ball of the given radius, seen from outside, with noise along the rays.
PointCloud ball(std::size_t count, double radius, double sigma, std::uint64_t seed) {
  Random random(seed);
  PointCloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 d = on_sphere(random);
    cloud.points.push_back((radius + sigma * random.normal()) * d);
    cloud.rays.push_back(-d);
  }
  return cloud;
}

/// Points on the faces of a cube of edge 2 * half.
PointCloud cube(std::size_t count, double half, double sigma, std::uint64_t seed, std::vector<Vec3>& truth) {
  Random random(seed);
  PointCloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const auto face = static_cast<int>(random.below(6));
    Vec3 n = Vec3::Zero();
    n[face / 2] = face % 2 ? 1 : -1;
    Vec3 p(random.uniform(-half, half), random.uniform(-half, half), random.uniform(-half, half));
    p[face / 2] = n[face / 2] * (half + sigma * random.normal());
    cloud.points.push_back(p);
    cloud.rays.push_back((-n + 0.3 * on_sphere(random)).normalized());
    truth.push_back(n);
  }
  return cloud;
}

double median_angle(const PointCloud& cloud, const std::vector<Vec3>& truth) {
  std::vector<double> angles;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    angles.push_back(std::atan2(cloud.normals[i].cross(truth[i]).norm(), cloud.normals[i].dot(truth[i])));
  return median_in_place(angles) * 180 / 3.14159265358979;
}

}  // namespace

TEST_CASE("normals: a ball's noise, spacing and directions are found at any density") {
  Context context;
  for (const std::size_t count : {2000u, 20000u, 200000u}) {
    PointCloud cloud = ball(count, 10, 0.05, 7);
    std::vector<Vec3> truth;
    for (const Vec3& p : cloud.points) truth.push_back(p.normalized());
    const SamplingSummary summary = estimate_normals(cloud, {}, context);
    INFO(count << " points, sigma " << summary.sigma << ", spacing " << summary.spacing);
    CHECK(summary.sigma == Approx(0.05).epsilon(0.25));
    CHECK(median_angle(cloud, truth) < 3.0);
    CHECK(summary.rejected < count / 500 + 2);
    for (const float s : cloud.sigma) REQUIRE(s == static_cast<float>(summary.sigma));
  }
}

TEST_CASE("normals: edges of a cube stay sharp and its points are kept") {
  Context context;
  std::vector<Vec3> truth;
  PointCloud cloud = cube(40000, 10, 0.02, 3, truth);
  const SamplingSummary summary = estimate_normals(cloud, {}, context);
  CHECK(summary.sigma == Approx(0.02).epsilon(0.2));
  CHECK(summary.rejected < 60);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (cloud.normals[i].dot(truth[i]) < 0.97) ++wrong;
  CHECK(wrong < cloud.size() * 4 / 100);
}

TEST_CASE("normals: points far off the surface are rejected, noise-free curved points are not") {
  Context context;
  PointCloud clean = ball(3000, 5, 0, 11);
  CHECK(estimate_normals(clean, {}, context).rejected == 0);

  PointCloud cloud = ball(20000, 10, 0.02, 5);
  Random random(9);
  for (std::size_t i = 0; i < 100; ++i)
    cloud.points[i] *= 1 + (random.uniform() < 0.5 ? -1 : 1) * random.uniform(0.03, 0.5);
  estimate_normals(cloud, {}, context);
  std::size_t found = 0, wrongly = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) (i < 100 ? found : wrongly) += cloud.rejected[i];
  CHECK(found >= 97);
  CHECK(wrongly < 20);
}

TEST_CASE("normals: the order in the file and the number of threads change nothing") {
  Context context;
  PointCloud cloud = ball(5000, 10, 0.05, 21), shuffled;
  std::vector<std::size_t> order(cloud.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  Random random(2);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  for (const std::size_t i : order) shuffled.points.push_back(cloud.points[i]), shuffled.rays.push_back(cloud.rays[i]);
  estimate_normals(cloud, {}, context);
  context.threads = 3;
  estimate_normals(shuffled, {}, context);
  for (std::size_t i = 0; i < order.size(); ++i) {
    REQUIRE(shuffled.normals[i] == cloud.normals[order[i]]);
    REQUIRE(shuffled.rejected[i] == cloud.rejected[order[i]]);
  }
  const auto kept = thinned(cloud.points, cloud.rejected, 0.7),
             kept_shuffled = thinned(shuffled.points, shuffled.rejected, 0.7);
  REQUIRE(kept.size() == kept_shuffled.size());
  for (std::size_t i = 0; i < kept.size(); ++i) REQUIRE(cloud.points[kept[i]] == shuffled.points[kept_shuffled[i]]);
}

TEST_CASE("normals: support follows the noise where points are far denser than it is thick") {
  constexpr double noise = 0.5;
  Context context;
  PointCloud round = ball(20000, 10, noise, 13);  // the nearest 400 points lie within two sigmas
  std::vector<Vec3> outward, faces;
  for (const Vec3& p : round.points) outward.push_back(p.normalized());
  PointCloud block = cube(20000, 10, noise, 13, faces);
  const auto without_rays = [&](PointCloud cloud, const std::vector<Vec3>& truth) {
    cloud.rays.clear();
    const SamplingSummary summary = estimate_normals(cloud, {}, context);
    CHECK(summary.sigma == Approx(noise).epsilon(0.1));
    CHECK(noise_along_normals(cloud, 1) == Approx(summary.sigma).epsilon(0.02));
    for (std::size_t i = 0; i < cloud.size(); ++i)
      if (cloud.normals[i].dot(truth[i]) < 0) cloud.normals[i] = -cloud.normals[i];
    CHECK(median_angle(cloud, truth) < 5);  // 42 degrees by the nearest 30, 60 would be chance
    CHECK(summary.rejected < cloud.size() / 500);
  };
  without_rays(round, outward);
  without_rays(block, faces);
}

TEST_CASE("normals: those that came with the data are kept") {
  Context context;
  PointCloud cloud = ball(2000, 10, 0.01, 4);
  for (const Vec3& p : cloud.points) cloud.normals.push_back(-p.normalized());
  const auto before = cloud.normals;
  const SamplingSummary summary = estimate_normals(cloud, {}, context);
  for (std::size_t i = 0; i < before.size(); ++i) REQUIRE((cloud.normals[i] - before[i]).norm() < 1e-12);
  CHECK(summary.spacing > 0);
}

TEST_CASE("normals: a handful of points, or none, does no harm") {
  Context context;
  PointCloud none;
  CHECK(estimate_normals(none, {}, context).spacing == 0);
  PointCloud few;
  few.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  estimate_normals(few, {}, context);
  CHECK(few.normals.size() == 4);
  PointCloud same;
  same.points.assign(100, Vec3(1, 2, 3));
  estimate_normals(same, {}, context);
  CHECK(same.normals.size() == 100);
}

TEST_CASE("thin: keeps about as many points as asked for, one per cube") {
  const PointCloud cloud = ball(50000, 10, 0, 8);
  const double spacing = spacing_for_count(cloud.points, 4000);
  const auto kept = thinned(cloud.points, {}, spacing);
  CHECK(kept.size() <= 4000);
  CHECK(kept.size() > 3600);
  CHECK(spacing_for_count(cloud.points, 50000) == 0);
  CHECK(thinned(cloud.points, {}, 0).size() == cloud.size());
}

TEST_CASE("normals: a million dense noisy points", "[.speed]") {
  Context context;
  context.threads = 2;
  PointCloud cloud = ball(1000000, 10, 0.05, 1);
  std::vector<Vec3> truth;
  for (const Vec3& p : cloud.points) truth.push_back(p.normalized());
  const auto start = std::chrono::steady_clock::now();
  const SamplingSummary summary = estimate_normals(cloud, {}, context);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  WARN(seconds << " s, sigma " << summary.sigma << ", median error " << median_angle(cloud, truth) << " deg, rejected "
               << summary.rejected);
  CHECK(median_angle(cloud, truth) < 3);
}
