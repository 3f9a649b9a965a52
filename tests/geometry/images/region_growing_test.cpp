#include "geometry/images/region_growing.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "geometry/normals/normals.h"
#include "testing/range_scenes.h"

using namespace partscribe::geometry;
using namespace partscribe::testing;

namespace {

Patches grown(const RangeScene& s, const PatchOptions& options = {}) {
  Context context;
  const auto graph = surface_graph(s.image, rlts_filter(s.image, {}, context), {});
  return grow_patches(graph, characterize(graph, {}, context), options, context);
}

double labelled(const Patches& p) {
  return 1 - static_cast<double>(std::count(p.label.begin(), p.label.end(), -1)) / static_cast<double>(p.label.size());
}

}  // namespace

TEST_CASE("region growing: two steps and a crease part a plane into four planes") {
  const auto s = range_scene({.width = 120}, [](double x, double y) {
    return 40 + (x < 30 ? 0 : x < 60 ? 6 : 3) + (x > 90 ? 0.7 * (x - 90.5) : 0.0) + 0.1 * y;
  });
  const auto p = grown(s);
  REQUIRE(p.patches.size() == 4);
  for (const auto& patch : p.patches) {
    CHECK(patch.order == 1);
    CHECK(patch.rms == Approx(1).epsilon(0.15));
  }
  CHECK(labelled(p) > 0.97);
  const auto counts = most_patches(p.label, 120, 60);
  CHECK(counts.along_row == 4);
  CHECK(counts.along_column == 1);
}

TEST_CASE("region growing: a flat arch on a plate is one second-order patch") {
  const auto s = range_scene({.width = 100, .height = 80}, [](double x, double y) {
    const double u = x - 50;
    return 60 - (std::abs(u) < 15 ? std::sqrt(60 * 60 - u * u) - 54 : 0.0) + 0.05 * y;
  });
  const auto p = grown(s);
  REQUIRE(p.patches.size() == 3);
  CHECK(std::count_if(p.patches.begin(), p.patches.end(), [](const auto& x) { return x.order == 2; }) == 1);
  CHECK(most_patches(p.label, 100, 80).along_row == 3);
  CHECK(labelled(p) > 0.9);
}

TEST_CASE("region growing: patches below the threshold are none") {
  const auto s = range_scene({}, [](double x, double y) { return 40 + (x > 70 && y > 52 ? 5 : 0.0); });
  const auto all = grown(s, {.least_points = 20}), large = grown(s, {.least_points = 100});
  CHECK(all.patches.size() == 2);
  REQUIRE(large.patches.size() == 1);
  CHECK(labelled(large) > 0.95);
  CHECK(labelled(large) < labelled(all));
}

TEST_CASE("region growing: a scanned box in a cloud has six planes") {
  Random random(12);
  Context context;
  PointCloud cloud;
  for (int i = 0; i < 12000; ++i) {
    const auto face = static_cast<int>(random.below(6));
    Vec3 p(random.uniform(-10, 10), random.uniform(-10, 10), random.uniform(-10, 10)), n = Vec3::Zero();
    n[face / 2] = face % 2 ? 1 : -1;
    p[face / 2] = n[face / 2] * (10 + 0.02 * random.normal());
    cloud.points.push_back(p), cloud.rays.push_back(-n);
  }
  estimate_normals(cloud, {}, context);
  const auto graph = surface_graph(cloud, {}, context);
  const auto p = grow_patches(graph, characterize(graph, {}, context), {.least_points = 200}, context);
  REQUIRE(p.patches.size() == 6);
  std::set<std::pair<int, int>> faces;
  for (const auto& patch : p.patches) {
    CHECK(patch.order == 1);
    const Vec3 n = patch.normal(patch.origin);
    int axis = 0;
    n.cwiseAbs().maxCoeff(&axis);
    CHECK(std::abs(n[axis]) > 0.9999);
    faces.insert({axis, n[axis] > 0});
  }
  CHECK(faces.size() == 6);
}

TEST_CASE("region growing: rows and columns count stretches, not specks or gaps") {
  // One patch, a speck of another, a gap, a third.
  const std::vector<int> row = {0, 0, 0, 1, 0, 0, -1, -1, 0, 0, 2, 2, 2, 2};
  CHECK(most_patches(row, 14, 1, 3).along_row == 2);
  CHECK(most_patches(row, 14, 1, 1).along_row == 4);
  CHECK(most_patches(row, 1, 14, 3).along_column == 2);
  CHECK(most_patches({}, 0, 0).along_row == 0);
}
