#include "scan/merge/merge.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "core/random.h"
#include "geometry/points/kd_tree.h"

using namespace partscribe::scan;

namespace {

constexpr double sigma = 0.05;

void add(PointCloud& cloud, const Vec3& place, const Vec3& normal, std::int32_t view, Random& random) {
  cloud.points.push_back(place + sigma * random.normal() * normal);
  cloud.normals.push_back(normal), cloud.sigma.push_back(float(sigma)), cloud.view.push_back(view);
}

/// Two views of a square of 20 mm in z = 0.
PointCloud plane_twice() {
  PointCloud cloud;
  Random random(3);
  for (std::int32_t view = 0; view < 2; ++view)
    for (int i = 0; i < 4000; ++i)
      add(cloud, {random.uniform(0, 20), random.uniform(0, 20), 0}, Vec3::UnitZ(), view, random);
  return cloud;
}

double rms_height(const PointCloud& cloud) {
  double sum = 0;
  for (const Vec3& p : cloud.points) sum += p.z() * p.z();
  return std::sqrt(sum / double(cloud.size()));
}

}  // namespace

TEST_CASE("merge: overlapping views become one cloud, less noisy, without a point twice") {
  const PointCloud cloud = plane_twice();
  Context context;
  MergeOptions options;
  options.spacing = 0.5;
  const MergedCloud merged = merge_views(cloud, options, context);
  CHECK(merged.cloud.size() < cloud.size() / 3);
  CHECK(rms_height(merged.cloud) < 0.75 * sigma);
  const KdTree tree(merged.cloud.points);
  std::vector<Neighbour> near;
  for (const Vec3& p : merged.cloud.points) {
    tree.nearest(p, 2, near);
    CHECK(near[1].sq_distance > 0.4 * 0.4);
  }
}

TEST_CASE("merge: of two views the surer one has the greater say, by its variance") {
  PointCloud cloud;
  for (std::int32_t view = 0; view < 2; ++view)
    for (int x = 0; x < 40; ++x)
      for (int y = 0; y < 40; ++y) {
        cloud.points.emplace_back(0.5 * x + 0.1 * view, 0.5 * y + 0.2 * view, view == 0 ? 0 : 0.06);
        cloud.normals.push_back(Vec3::UnitZ()), cloud.view.push_back(view);
        cloud.sigma.push_back(view == 0 ? 0.02F : 0.04F);
      }
  Context context;
  MergeOptions options;
  options.spacing = 0.8;
  const MergedCloud merged = merge_views(cloud, options, context);
  REQUIRE(merged.cloud.size() > 300);
  // Weights 1 / 0.02^2 and 1 / 0.04^2: four parts to one.
  for (const Vec3& p : merged.cloud.points) CHECK(p.z() == Approx(0.06 / 5).margin(1e-6));
  for (const float s : merged.cloud.sigma) CHECK(s == Approx(0.04 / std::sqrt(5.0)).epsilon(1e-4));
}

TEST_CASE("merge: every sample stands behind one merged point") {
  PointCloud cloud = plane_twice();
  cloud.rejected.assign(cloud.size(), 0);
  cloud.rejected[17] = 1;
  Context context;
  const MergedCloud merged = merge_views(cloud, {}, context);
  REQUIRE(merged.first.size() == merged.cloud.size() + 1);
  const std::set<std::uint32_t> samples(merged.sample.begin(), merged.sample.end());
  CHECK(samples.size() == merged.sample.size());
  CHECK(samples.size() == cloud.size() - 1);
  CHECK(samples.count(17) == 0);
}

TEST_CASE("merge: both sides of a wall thinner than the spacing stay where they are") {
  PointCloud cloud;
  Random random(4);
  for (std::int32_t view = 0; view < 2; ++view)
    for (int i = 0; i < 3000; ++i) {
      const double x = random.uniform(0, 20), y = random.uniform(0, 20);
      add(cloud, {x, y, view == 0 ? 0.2 : -0.2}, view == 0 ? Vec3(0, 0, 1) : Vec3(0, 0, -1), view, random);
    }
  Context context;
  MergeOptions options;
  options.spacing = 0.6;
  const MergedCloud merged = merge_views(cloud, options, context);
  for (std::size_t i = 0; i < merged.cloud.size(); ++i) {
    const Vec3& p = merged.cloud.points[i];
    CHECK(p.z() * merged.cloud.normals[i].z() > 0);
    CHECK(std::abs(std::abs(p.z()) - 0.2) < 5 * sigma);
  }
}

TEST_CASE("merge: a sharp edge is not rounded") {
  PointCloud cloud;
  Random random(5);
  for (std::int32_t view = 0; view < 3; ++view)
    for (int i = 0; i < 4000; ++i) {
      const double x = random.uniform(0, 10), y = random.uniform(0, 20);
      if (i % 2)
        add(cloud, {x, y, 0}, Vec3::UnitZ(), view, random);
      else
        add(cloud, {0, y, -x}, Vec3(-1, 0, 0), view, random);
    }
  Context context;
  const MergedCloud merged = merge_views(cloud, {}, context);
  double sum = 0;
  for (const Vec3& p : merged.cloud.points) {
    // Distance from the quarter space x > 0, z < 0.
    const double d =
        p.x() > 0 && p.z() < 0 ? -std::min(p.x(), -p.z()) : std::hypot(std::min(p.x(), 0.0), std::max(p.z(), 0.0));
    CHECK(std::abs(d) < 5 * sigma);
    sum += d;
  }
  CHECK(std::abs(sum / double(merged.cloud.size())) < 0.2 * sigma);
}

TEST_CASE("merge: a sample that nobody confirms is left out, and its place goes to others") {
  PointCloud cloud = plane_twice();
  cloud.points[40].z() += 0.4, cloud.points[4040].z() -= 0.6;
  cloud.sigma[40] = cloud.sigma[4040] = 0.01F;  // the first to be asked
  Context context;
  const MergedCloud merged = merge_views(cloud, {}, context);
  for (const Vec3& p : merged.cloud.points) CHECK(std::abs(p.z()) < 5 * sigma);
  const KdTree tree(merged.cloud.points);
  for (const std::size_t i : {40, 4040}) CHECK(tree.nearest_one(cloud.points[i]).sq_distance < 1);
}

TEST_CASE("merge: a wire of single samples, a step and the far end of a sparse view stay") {
  PointCloud cloud;
  Random random(6);
  for (int i = 0; i < 60; ++i) add(cloud, {0.3 * i, -3, 5}, Vec3::UnitZ(), 0, random);  // a wire
  for (std::int32_t view = 0; view < 2; ++view)
    for (int x = 0; x < 60; ++x)
      for (int y = 0; y < 40; ++y) add(cloud, {0.3 * x, 0.3 * y, y < 20 ? 0.0 : 0.5}, Vec3::UnitZ(), view, random);
  for (int x = 0; x < 6; ++x)
    for (int y = 0; y < 6; ++y) add(cloud, {30 + 4.0 * x, 4.0 * y, 0}, Vec3::UnitZ(), 1, random);
  Context context;
  const MergedCloud merged = merge_views(cloud, {}, context);
  const KdTree tree(merged.cloud.points);
  std::size_t gone = 0;
  for (const Vec3& p : cloud.points) gone += tree.nearest_one(p).sq_distance > 0.4 * 0.4;
  CHECK(gone == 0);
}

TEST_CASE("merge: of a thin wall a side of few samples stays beside one of many") {
  PointCloud cloud;
  Random random(7);
  for (int x = 0; x < 100; ++x)
    for (int y = 0; y < 100; ++y) add(cloud, {0.1 * x, 0.1 * y, 0.15}, Vec3::UnitZ(), 0, random);
  for (int x = 0; x < 10; ++x)
    for (int y = 0; y < 10; ++y) add(cloud, {x + 0.1, y + 0.1, -0.15}, -Vec3::UnitZ(), 1, random);
  Context context;
  const MergedCloud merged = merge_views(cloud, {}, context);
  CHECK(std::count_if(merged.cloud.normals.begin(), merged.cloud.normals.end(),
                      [](const Vec3& n) { return n.z() < 0; }) == 100);
}

TEST_CASE("merge: the same for any number of threads, bad input gives nothing") {
  const PointCloud cloud = plane_twice();
  Context one, four;
  one.threads = 1, four.threads = 4;
  const MergedCloud a = merge_views(cloud, {}, one), b = merge_views(cloud, {}, four);
  CHECK(a.cloud.points == b.cloud.points);
  CHECK(a.sample == b.sample);
  CHECK(merge_views({}, {}, one).cloud.empty());
}
