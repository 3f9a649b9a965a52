#include "scan/views/next_views.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

using namespace partscribe::scan;

namespace {

/// A ball of radius 20, seen along parallel rays from these directions.
Scan ball_from(const std::vector<Vec3>& sensors) {
  Scan scan;
  for (std::size_t v = 0; v < sensors.size(); ++v) {
    const Vec3& d = sensors[v];
    const Vec3 u = d.unitOrthogonal(), w = d.cross(u);
    for (double x = -20; x <= 20; x += 0.4)
      for (double y = -20; y <= 20; y += 0.4) {
        const double sq = 400 - x * x - y * y;
        if (sq < 0) continue;
        scan.cloud.points.push_back(x * u + y * w + std::sqrt(sq) * d);
        scan.cloud.rays.push_back(-d), scan.cloud.view.push_back(static_cast<std::int32_t>(v));
      }
    scan.views.push_back({});
  }
  return scan;
}

}  // namespace

TEST_CASE("next views: the far side of a ball comes next") {
  Context context;
  const NextViews plan = next_views(ball_from({Vec3::UnitZ()}), {}, context);
  REQUIRE(!plan.views.empty());
  CHECK(plan.unseen > 0);
  // Not straight from behind: part of what is known must be in the picture.
  Vec3 sum = Vec3::Zero();
  for (const auto& view : plan.views) sum += view.direction;
  CHECK(sum.z() < 0);
  CHECK(plan.views[0].direction.z() < 0.3);
  CHECK(plan.views[0].gain > 0.1 * plan.seen);
}

TEST_CASE("next views: each adds less than the one before, and what is seen all around needs none") {
  Context context;
  const NextViews half = next_views(ball_from({Vec3::UnitZ(), Vec3::UnitX()}), {}, context);
  for (std::size_t i = 1; i < half.views.size(); ++i) CHECK(half.views[i].gain <= 1.5 * half.views[i - 1].gain);
  std::vector<Vec3> all;
  for (int k = 0; k < 3; ++k) all.push_back(Vec3::Unit(k)), all.push_back(-Vec3::Unit(k));
  const NextViews done = next_views(ball_from(all), {}, context);
  CHECK(done.views.empty());
  CHECK(done.unseen < 0.05 * done.seen);
}

TEST_CASE("next views: without rays nothing is known of empty space") {
  Context context;
  Scan scan = ball_from({Vec3::UnitZ()});
  scan.cloud.rays.clear();
  CHECK(next_views(scan, {}, context).views.empty());
  CHECK(next_views({}, {}, context).views.empty());
}
