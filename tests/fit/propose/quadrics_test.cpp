/// Starts for balls, ellipsoids and superellipsoids from whole, one-sided and soiled data.
#include "fit/propose/quadrics.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"

using namespace partscribe::fit;

namespace {

Vec3 gaussian(Random& random) { return {random.normal(), random.normal(), random.normal()}; }

/// Points of an ellipsoid (turned, moved) that are visible from above with cos > `least`; -2 for all of it.
FitInput scanned(const Vec3& radii, double noise, double outliers, double least, std::uint64_t seed) {
  Random random(seed);
  const Pose pose{rotation_of({0.5, 0.2, -0.9}), {12, -7, 300}};
  FitInput input;
  while (input.cloud.size() < 4000) {
    const Vec3 u = gaussian(random).normalized(), n = u.cwiseQuotient(radii).normalized();
    if (random.uniform() * 1 > Vec3(u.cwiseQuotient(radii)).norm() * radii.minCoeff()) continue;  // even density
    if (n.z() < least) continue;
    Vec3 p = u.cwiseProduct(radii) + noise * random.normal() * n;
    Vec3 m = (n + 0.03 * gaussian(random)).normalized();
    if (random.uniform() < outliers)
      p = 1.3 * radii.maxCoeff() * Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)),
      m = gaussian(random).normalized();
    input.cloud.points.push_back(pose * p);
    input.cloud.normals.push_back((random.uniform() < 0.5 ? -1 : 1) * (pose.rotation * m));
  }
  input.sampling.sigma = noise;
  input.sampling.spacing = input.thin_spacing = 1;
  input.tolerance = 0.1;
  input.bounds = input.cloud.bounds();
  return input;
}

std::vector<Candidate> proposed(const FitInput& input) {
  Context context;
  const SuperellipsoidFit hypothesis = recover_superellipsoid(input.cloud.points, context);
  std::vector<Candidate> all = propose_quadrics(input, hypothesis, context);
  for (auto& c : propose_superellipsoids(input, hypothesis)) all.push_back(std::move(c));
  return all;
}

const Candidate* find(const std::vector<Candidate>& candidates, const std::string& procedure) {
  for (const Candidate& c : candidates)
    if (c.procedure == procedure) return &c;
  return nullptr;
}

}  // namespace

TEST_CASE("quadrics: a ball seen whole, from one side, and as a cap with a tenth of outliers") {
  for (double least : {-2.0, 0.2, 0.6})
    for (double outliers : {0.0, 0.1}) {
      const auto candidates = proposed(scanned({20, 20, 20}, 0.02, outliers, least, 3));
      INFO("visible above " << least << ", outliers " << outliers);
      const Candidate* ball = find(candidates, "sphere");
      REQUIRE(ball);
      CHECK(ball == &candidates.front());
      REQUIRE(ball->parameters.size() == 1);
      CHECK(ball->parameters[0].name == "radius");
      CHECK(ball->parameters[0].value == Approx(20).margin(least > 0.5 ? 0.05 : 0.01));
      CHECK((ball->scan_from_part.translation - Vec3(12, -7, 300)).norm() < (least > 0.5 ? 0.06 : 0.01));
    }
}

TEST_CASE("quadrics: an ellipsoid comes with its longest axis along x, from whole and from one-sided data") {
  for (double least : {-2.0, 0.0}) {
    const auto candidates = proposed(scanned({12, 40, 25}, 0.02, 0.05, least, 5));
    INFO("visible above " << least);
    CHECK(find(candidates, "sphere") == nullptr);
    const Candidate* e = find(candidates, "ellipsoid");
    REQUIRE(e);
    CHECK(e->parameters[0].value == Approx(40).margin(0.3));
    CHECK(e->parameters[1].value == Approx(25).margin(0.3));
    CHECK(e->parameters[2].value == Approx(12).margin(0.3));
    const Mat3 truth = rotation_of({0.5, 0.2, -0.9});
    CHECK(std::abs(e->scan_from_part.rotation.col(0).dot(truth.col(1))) > 0.999);
    CHECK(e->scan_from_part.rotation.determinant() == Approx(1));
  }
}

TEST_CASE("quadrics: a rounded block comes as a superellipsoid with exponents and half sizes") {
  Random random(6);
  FitInput input;
  const Vec3 a(30, 20, 12);
  while (input.cloud.size() < 4000) {  // projected along rays from a box grown around it, exponents 0.4
    Vec3 q(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    q[static_cast<int>(random.below(3))] = random.uniform() < 0.5 ? -1 : 1;
    const double p = 2 / 0.4;
    double n = 0;
    for (int k = 0; k < 3; ++k) n += std::pow(std::abs(q[k]), p);
    input.cloud.points.push_back(a.cwiseProduct(q / std::pow(n, 1 / p)) + 0.02 * gaussian(random));
    input.cloud.normals.push_back(q.normalized());
  }
  input.sampling.sigma = 0.02, input.tolerance = 0.1, input.bounds = input.cloud.bounds();
  const auto candidates = proposed(input);
  const Candidate* s = find(candidates, "superellipsoid");
  REQUIRE(s);
  CHECK(find(candidates, "sphere") == nullptr);
  REQUIRE(s->parameters.size() == 5);
  std::vector<double> sizes = {s->parameters[0].value, s->parameters[1].value, s->parameters[2].value};
  std::sort(sizes.begin(), sizes.end());
  CHECK(sizes[0] == Approx(12).margin(0.1));
  CHECK(sizes[2] == Approx(30).margin(0.1));
  CHECK(s->parameters[3].value == Approx(0.4).margin(0.03));
  CHECK(s->parameters[4].value == Approx(0.4).margin(0.03));
}

TEST_CASE("quadrics: a plane, a cylinder and an empty cloud are none") {
  Random random(8);
  FitInput plane, cylinder;
  for (int i = 0; i < 3000; ++i) {
    plane.cloud.points.emplace_back(random.uniform(-50, 50), random.uniform(-50, 50), 0.02 * random.normal());
    plane.cloud.normals.emplace_back(0, 0, 1);
    const double t = random.uniform(0, 6.283185);
    cylinder.cloud.points.emplace_back(15 * std::cos(t), 15 * std::sin(t), random.uniform(-40, 40));
    cylinder.cloud.normals.emplace_back(std::cos(t), std::sin(t), 0);
  }
  plane.bounds = plane.cloud.bounds(), cylinder.bounds = cylinder.cloud.bounds();
  CHECK(find(proposed(plane), "sphere") == nullptr);
  CHECK(find(proposed(cylinder), "sphere") == nullptr);
  CHECK(proposed(FitInput{}).empty());
}

TEST_CASE("superellipsoids: a section that is nearly a diamond is proposed as a rounded square as well") {
  const FitInput input = scanned({20, 20, 12}, 0.05, 0, -2, 6);
  SuperellipsoidFit fit;
  Hypothesis& h = fit.hypothesis;
  h.a1 = h.a2 = 21, h.a3 = 12, h.e1 = 1, h.e2 = 1.2, h.taper_x = 0.01;
  fit.scan_from_shape = {rotation_of({0.5, 0.2, -0.9}), {12, -7, 300}};
  const auto proposed = propose_superellipsoids(input, fit);
  REQUIRE(proposed.size() == 2);
  CHECK(proposed[0].parameters.size() == 7);
  REQUIRE(proposed[1].parameters.size() == 5);
  CHECK(proposed[1].parameters[4].value == Approx(0.8));
  // Along both the axes and the diagonals of its section it reaches as far as the diamond.
  const double way = proposed[1].parameters[0].value;
  CHECK(way == Approx(21 * std::sqrt(2) * std::pow(0.5, 0.6)));
  CHECK(way * std::sqrt(2) * std::pow(0.5, 0.4) == Approx(21));
  const Mat3 turn = fit.scan_from_shape.rotation.transpose() * proposed[1].scan_from_part.rotation;
  CHECK((turn * Vec3(1, 0, 0) - Vec3(1, 1, 0).normalized()).norm() < 1e-12);
  h.e2 = 1.05;
  CHECK(propose_superellipsoids(input, fit).size() == 1);
}
