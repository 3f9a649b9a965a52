#include "fit/surface/height_map.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"
#include "fit/build.h"
#include "fit/evidence/evidence.h"
#include "fit/input/prepare.h"
#include "fit/procedures.h"
#include "fit/surface/free_form.h"

using namespace partscribe::fit;

namespace {

double height(double x, double y) { return 3 * std::sin(x / 9) * std::cos(y / 11); }

/// Columns 0.8 and rows 0.6 mm apart, in any order, with heights along the axis `up`.
PointCloud map_of(int up, double noise) {
  Random random(4);
  PointCloud cloud;
  for (int i = 0; i < 60; ++i)
    for (int j = 0; j < 50; ++j) {
      Vec3 p;
      p[(up + 1) % 3] = 0.8 * i, p[(up + 2) % 3] = 0.6 * j;
      p[up] = height(0.8 * i, 0.6 * j) + noise * random.normal();
      cloud.points.push_back(p);
    }
  std::reverse(cloud.points.begin(), cloud.points.begin() + 700);
  return cloud;
}

}  // namespace

TEST_CASE("height map: points over a grid of two coordinates, whichever is the height") {
  for (const int up : {0, 1, 2}) {
    const auto grid = height_map_of(map_of(up, 0));
    REQUIRE(grid);
    CHECK(grid->u.size() == 60);
    CHECK(grid->v.size() == 50);
    const Vec3 p = grid->points[7 * 50 + 3];
    CHECK(p[(up + 1) % 3] == Approx(5.6));
    CHECK(p[(up + 2) % 3] == Approx(1.8));
    CHECK(p[up] == Approx(height(5.6, 1.8)));
  }
}

TEST_CASE("height map: a missing, doubled or shifted point, or one set aside, leaves none") {
  const PointCloud whole = map_of(2, 0);
  PointCloud cloud = whole;
  cloud.points.pop_back();
  CHECK_FALSE(height_map_of(cloud));
  cloud.points.push_back(cloud.points.front());
  CHECK_FALSE(height_map_of(cloud));
  cloud = whole, cloud.points[100].x() += 0.01;
  CHECK_FALSE(height_map_of(cloud));
  cloud = whole, cloud.rejected.assign(cloud.size(), 0), cloud.rejected[9] = 1;
  CHECK_FALSE(height_map_of(cloud));
}

TEST_CASE("height map: one surface with few control points over the whole rectangle") {
  Context context;
  Scan scan;
  scan.cloud = map_of(2, 0.01);
  const auto input = prepare(scan, 0.1, context);
  REQUIRE(input.ok());
  const auto candidate = free_form_of_map(*input, context);
  REQUIRE(candidate);
  const auto& set = std::get<SurfaceSet>(candidate->shape);
  REQUIRE(set.patches.size() == 1);
  CHECK(set.patches[0].trims.size() == 4);
  CHECK(set.patches[0].control.size() < 150);
  CHECK(evidence_of(*candidate, *input, context).local_max < 0.1);
}

TEST_CASE("height map: free form that is asked for by name is searched for no procedure, and is no fallback") {
  Scan scan;
  scan.cloud = map_of(2, 0.01);
  BuildOptions options;
  options.tolerance = 0.1, options.force = only_free_form;
  std::string log;
  Context context;
  context.log = [&](const std::string& line) { log += line + "\n"; };
  const auto model = build_model(scan, options, context);
  REQUIRE(model.ok());
  CHECK_FALSE((*model)->fallback);
  CHECK(std::holds_alternative<SurfaceSet>((*model)->objects.back().shape));
  CHECK(log.find("free form: a height map of 60 x 50 points") != std::string::npos);
  CHECK(log.find("deviation") == log.find("free form: deviation") + 11);
}
