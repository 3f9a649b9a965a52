/// A body that stands between the sensor and what it saw is not the part.
#include "fit/evidence/seen_through.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "fit/build.h"

namespace partscribe::testing {

using namespace fit;

namespace {

constexpr double radius = 20, rod_length = 60, noise = 0.1, tolerance = 3 * noise;

/// Half of a cylinder's wall, seen from above by parallel rays: its outside, or the inside of a trough of that form.
Scan half_wall(bool outside) {
  Scan scan;
  scan.files = {"simulated"};
  scan.views.push_back({"simulated", {}, false, 0, 0});
  Random random(7);
  const Vec3 down(0, 0, -1);
  while (scan.cloud.size() < 4000) {
    const double x = radius * random.uniform(-0.95, 0.95), z = std::sqrt(radius * radius - x * x);
    scan.cloud.points.push_back(Vec3(x, rod_length * random.uniform(), outside ? z : -z) +
                                noise * random.normal() * down);
    scan.cloud.rays.push_back(down), scan.cloud.view.push_back(0);
  }
  return scan;
}

FitInput input_of(const Scan& scan) {
  FitInput input;
  input.cloud = scan.cloud, input.bounds = scan.cloud.bounds(), input.sampling.sigma = noise,
  input.tolerance = tolerance;
  return input;
}

/// The solid with that wall.
Candidate rod() {
  Candidate c;
  c.procedure = "cylinder", c.object_name = "rod", c.shape = Cylinder{Expr(radius), Expr(rod_length)};
  c.scan_from_part.rotation = rotation_of(Vec3(-pi / 2, 0, 0));
  return c;
}

Result<CheckedModel> built(Scan scan) {
  Context context;
  BuildOptions options;
  options.tolerance = tolerance, options.triangulate = false;
  return build_model(scan, options, context);
}

bool is_rod(const Result<CheckedModel>& model) {
  return model.ok() && std::holds_alternative<Cylinder>((**model).objects.back().shape);
}

}  // namespace

TEST_CASE("seen through: nothing of a rod's outside, nearly all of it where its inside was seen") {
  Context context;
  CHECK(share_seen_through(rod(), input_of(half_wall(true)), context) < 0.001);
  CHECK(share_seen_through(rod(), input_of(half_wall(false)), context) > 0.95);
}

TEST_CASE("seen through: where no rays are known nobody can say") {
  Context context;
  FitInput input = input_of(half_wall(false));
  input.cloud.rays.clear();
  CHECK(share_seen_through(rod(), input, context) == 0);
  input.cloud.rays.assign(input.cloud.size(), Vec3(0, 0, 0));
  CHECK(share_seen_through(rod(), input, context) == 0);
}

TEST_CASE("seen through: points behind a body do not lie on it") {
  Context context;
  FitInput input = input_of(half_wall(false));
  for (Vec3& p : input.cloud.points) p.z() -= radius;
  CHECK(share_seen_through(rod(), input, context) == 0);
}

TEST_CASE("seen through: the wall of a trough is not taken for a rod, that of a rod is") {
  CHECK(is_rod(built(half_wall(true))));
  CHECK_FALSE(built(half_wall(false)).ok());
}

}  // namespace partscribe::testing
