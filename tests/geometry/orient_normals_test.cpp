#include "geometry/orient_normals.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"
#include "geometry/normals.h"

using namespace partscribe;

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

TEST_CASE("orient normals: nothing to do for no points") {
  Context context;
  PointCloud none;
  CHECK(orient_normals(none, 10, context) == 0);
}
