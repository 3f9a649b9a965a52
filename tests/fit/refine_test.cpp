// Refinement: as good as an independent solver, and honest about its uncertainty.
#include <ceres/ceres.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "fit/prepare.h"
#include "fit/refine.h"
#include "tests/fit/sampled.h"
#include "tests/model/parts.h"

using namespace partscribe;

namespace {

FitInput input_of(Scan& scan, double tolerance) {
  Context context;
  auto input = prepare(scan, tolerance, context);
  REQUIRE(input.ok());
  return std::move(*input);
}

Candidate cylinder_start(double radius, double height, const Pose& pose) {
  Candidate c;
  c.object_name = "rod";
  c.shape = Cylinder{Expr::of("radius"), Expr::of("height")};
  c.parameters = {test::length("radius", radius), test::length("height", height)};
  c.scan_from_part = pose;
  return c;
}

struct SphereResidual {
  Vec3 p;
  template <class T>
  bool operator()(const T* center, const T* radius, T* residual) const {
    const T dx = T(p.x()) - center[0], dy = T(p.y()) - center[1], dz = T(p.z()) - center[2];
    residual[0] = sqrt(dx * dx + dy * dy + dz * dz) - radius[0];
    return true;
  }
};

}  // namespace

TEST_CASE("refine: the sphere that Ceres finds on the same points") {
  Model truth = test::model_with(Sphere{12});
  test::Sampling s;
  s.points = 3000, s.reach = 20;
  Scan scan = test::sampled(truth, s);
  const FitInput input = input_of(scan, 0.1);
  Candidate c;
  c.object_name = "ball";
  c.shape = Sphere{Expr::of("radius")};
  c.parameters = {test::length("radius", 11)};
  c.scan_from_part.translation = {1, -1, 0.5};
  Context context;
  RefineOptions options;
  options.welsch = 1e6;  // plain least squares, as the other does
  const auto report = refine(c, input, options, context);
  CHECK(report.converged);
  double center[3] = {0.5, 0.5, 0.5}, radius = 10;
  ceres::Problem problem;
  for (const auto& p : input.cloud.points)
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<SphereResidual, 1, 3, 1>(new SphereResidual{p}), nullptr, center, &radius);
  ceres::Solver::Options solver;
  solver.function_tolerance = 1e-15;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  CHECK(c.parameters[0].value == Approx(radius).margin(1e-6));
  CHECK((c.scan_from_part.translation - Vec3(center[0], center[1], center[2])).norm() < 1e-5);
}

TEST_CASE("refine: a cylinder comes home from a start that is well off") {
  const Pose truth{rotation_of({0.3, -0.5, 0}), {4, 5, 6}};
  Model model = test::model_with(Cylinder{8, 25});
  const Vec3 angles = euler_from_rotation(truth.rotation);
  model.scan_from_part = {4, 5, 6, angles.x(), angles.y(), angles.z()};
  Scan scan = test::sampled(model, {});
  const FitInput input = input_of(scan, 0.1);
  Candidate c = cylinder_start(7, 23, {rotation_of({0.2, -0.4, 0}), {5, 4.5, 6.5}});
  Context context;
  const auto report = refine(c, input, {}, context);
  CHECK(report.converged);
  CHECK(report.rms == Approx(0.02).epsilon(0.1));
  CHECK(std::abs(c.parameters[0].value - 8) < 3 * c.parameters[0].sigma);
  CHECK(std::abs(c.parameters[1].value - 25) < 3 * c.parameters[1].sigma);
}

TEST_CASE("refine: the noise part of sigma holds the truth as often as it says") {
  Context context;
  int inside = 0;
  const int runs = 60;
  for (int run = 0; run < runs; ++run) {
    test::Sampling s;
    s.points = 400, s.noise = 0.05, s.reach = 20, s.seed = 100 + static_cast<std::uint64_t>(run);
    Scan scan = test::sampled(test::model_with(Sphere{12}), s);
    FitInput input;
    input.cloud = scan.cloud;
    input.bounds = input.cloud.bounds();
    input.sampling.sigma = 0.05;
    input.thin_spacing = 2;
    Candidate c;
    c.object_name = "ball";
    c.shape = Sphere{Expr::of("radius")};
    c.parameters = {test::length("radius", 11.5)};
    refine(c, input, {}, context);
    inside += std::abs(c.parameters[0].value - 12) < 1.96 * c.parameters[0].sigma_noise;
  }
  // 95 % of 60 is 57; fewer than 51 or all 60 with far too wide intervals would be a lie.
  CHECK(inside >= 51);
}
