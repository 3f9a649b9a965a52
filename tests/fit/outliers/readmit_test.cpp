/// The last refinement among outliers: what was set aside near the surface comes back, and only that.
#include "fit/outliers/readmit.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"

using namespace partscribe::fit;

namespace {

constexpr double radius = 20, noise = 0.5;

Candidate ellipsoid(double r) {
  Candidate c;
  c.procedure = "ellipsoid", c.object_name = "ellipsoid_body",
  c.shape = Ellipsoid{Expr::of("radius_x"), Expr::of("radius_y"), Expr::of("radius_z")};
  for (const char* name : {"radius_x", "radius_y", "radius_z"}) {
    Parameter p;
    p.name = name, p.quantity = Quantity::length, p.value = p.fitted = r;
    c.parameters.push_back(p);
  }
  return c;
}

/// A ball seen from above. On its slope what lies farther out than the surface was taken for outliers, with true ones.
FitInput soiled() {
  FitInput input;
  Random random(3);
  const auto add = [](PointCloud& to, const Vec3& p, const Vec3& n) {
    to.points.push_back(p), to.normals.push_back(n);
  };
  while (input.cloud.size() < 2000) {
    const Vec3 n = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    if (n.z() < 0.2) continue;
    const double d = noise * random.normal();
    add(n.z() < 0.5 && d > 0 ? input.set_aside : input.cloud, (radius + d) * n, n);
  }
  for (int i = 0; i < 300; ++i) {
    const Vec3 n = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    add(input.set_aside, (radius + random.uniform(4, 10)) * n, n);
  }
  input.bounds = input.cloud.bounds();
  input.sampling.sigma = noise, input.tolerance = 3 * noise, input.outlier_share = 0.2;
  return input;
}

}  // namespace

TEST_CASE("readmit: points of a slope that were taken for outliers no longer draw the fit inwards") {
  const FitInput input = soiled();
  Context context;
  RefineOptions options;
  Candidate without = ellipsoid(19), with = without;
  refine(without, input, options, context);
  refine_with_outliers_near(with, input, options, context);
  for (std::size_t k = 0; k < 2; ++k) {
    CHECK(without.parameters[k].value < radius - 0.4);
    CHECK(with.parameters[k].value == Approx(radius).margin(0.15));
    CHECK(std::abs(with.parameters[k].value - radius) < 4 * with.parameters[k].sigma);
  }
}

TEST_CASE(
    "readmit: a ball among few outliers has the points of its slope back, and is not drawn to where the outliers are") {
  FitInput input = soiled();
  input.outlier_share = 0.08;
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    const Vec3 n = Vec3(random.normal(), random.normal(), 3 * random.uniform()).normalized();
    const double out = noise * random.uniform(2, 12);
    input.set_aside.points.push_back((radius + out) * n), input.set_aside.normals.push_back(n);
  }
  Candidate ball = ellipsoid(19.5);
  ball.procedure = "sphere", ball.shape = Sphere{Expr::of("radius_x")}, ball.parameters.resize(1);
  Context context;
  refine_with_outliers_near(ball, input, {}, context);
  CHECK(ball.parameters[0].value == Approx(radius).margin(0.1));
}

TEST_CASE("readmit: without outliers it is the usual refinement") {
  FitInput input = soiled();
  input.set_aside = {};
  Context context;
  Candidate one = ellipsoid(19), two = one;
  refine(one, input, {}, context);
  refine_with_outliers_near(two, input, {}, context);
  CHECK(one.parameters[0].value == two.parameters[0].value);
  CHECK(one.parameters[0].sigma == two.parameters[0].sigma);
}
