#include "geometry/surfaces/nurbs_nearest.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/number.h"
#include "geometry/surfaces/nurbs_edit.h"
#include "geometry/surfaces/nurbs_exact.h"

namespace partscribe::geometry {
namespace {

/// Folded, so that most points have several feet.
NurbsSurface folded(int degree, bool rational, unsigned seed) {
  NurbsSurface s{clamped(degree, {0, 1, 2, 3}), clamped(degree, {0, 2, 3}), {}, {}};
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> off(-12, 12), weight(0.4, 2.5);
  for (int i = 0; i < s.u.count(); ++i)
    for (int j = 0; j < s.v.count(); ++j) {
      const double x = off(random), y = off(random), z = off(random);
      s.points.emplace_back(6 * i + 0.5 * x, 7 * j + 0.5 * y, z);
      if (rational) s.weights.push_back(weight(random));
    }
  return s;
}

}  // namespace

TEST_CASE("nurbs_nearest: no sample of a folded surface or of its curves is nearer than the foot") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(-10, 40);
  for (const bool rational : {false, true})
    for (int degree = 1; degree <= 5; ++degree) {
      const auto s = folded(degree, rational, unsigned(degree));
      const auto c = iso_curve(s, true, 1.3);
      for (int k = 0; k < 12; ++k) {
        const Vec3 p(coordinate(random), coordinate(random), coordinate(random) - 15);
        const auto foot = nearest_on(s, p), on_curve = nearest_on(c, p);
        CHECK((s.at(foot.u, foot.v) - foot.point).norm() < 1e-12);
        CHECK((foot.point - p).norm() == Approx(foot.distance));
        CHECK((c.at(on_curve.u) - on_curve.point).norm() < 1e-12);
        CHECK((on_curve.point - p).norm() == Approx(on_curve.distance));
        CHECK(foot.distance <= on_curve.distance + 1e-9);
        double least = 1e300, least_on_curve = 1e300;
        for (int i = 0; i <= 120; ++i) {
          least_on_curve = std::min(least_on_curve, (c.at(i / 40.0) - p).norm());
          for (int j = 0; j <= 120; ++j) least = std::min(least, (s.at(i / 40.0, j / 40.0) - p).norm());
        }
        CHECK(foot.distance <= least + 1e-9);
        CHECK(foot.distance > least - 1);
        CHECK(on_curve.distance <= least_on_curve + 1e-9);
        CHECK(on_curve.distance > least_on_curve - 1);
      }
    }
}

TEST_CASE("nurbs_nearest: distances to quadrics are those of their equations") {
  const auto sphere = exact_sphere(5), torus = exact_torus(10, 3);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coordinate(-14, 14);
  for (int k = 0; k < 100; ++k) {
    const Vec3 p(coordinate(random), coordinate(random), coordinate(random));
    CHECK(nearest_on(sphere, p).distance == Approx(std::abs(p.norm() - 5)).margin(1e-8));
    CHECK(nearest_on(torus, p).distance ==
          Approx(std::abs(std::hypot(std::hypot(p.x(), p.y()) - 10, p.z()) - 3)).margin(1e-8));
  }
  // All places are equally near: one of them is found, without looking at all.
  CHECK(nearest_on(sphere, Vec3::Zero()).distance == Approx(5).epsilon(1e-12));
  CHECK(nearest_on(torus, Vec3::Zero()).distance == Approx(7).epsilon(1e-12));
  CHECK(nearest_on(torus, Vec3(0, 0, 4)).distance == Approx(std::hypot(10, 4) - 3).epsilon(1e-10));
}

TEST_CASE("nurbs_nearest: a point of the surface is its own foot, a corner is the foot of what is beyond it") {
  const auto s = folded(3, true, 8);
  for (const double u : {0.0, 0.7, 2.0, 3.0})
    for (const double v : {0.0, 1.7, 3.0}) CHECK(nearest_on(s, s.at(u, v)).distance < 1e-8);
  const NurbsSurface plate{
      clamped(1, {0, 4}), clamped(1, {0, 3}), {Vec3(0, 0, 0), Vec3(0, 3, 0), Vec3(4, 0, 0), Vec3(4, 3, 0)}, {}};
  const auto corner = nearest_on(plate, Vec3(7, 5, 1));
  CHECK(corner.u == 4);
  CHECK(corner.v == 3);
  CHECK(corner.distance == Approx(std::sqrt(14.0)));
  const auto inside = nearest_on(plate, Vec3(1.25, 2.5, -2));
  CHECK(inside.u == Approx(1.25));
  CHECK(inside.v == Approx(2.5));
  CHECK(inside.distance == Approx(2));
}

TEST_CASE("nurbs_nearest: the far arm of a horseshoe is found, where the steps from the near end lead elsewhere") {
  const NurbsCurve<3> shoe{clamped(3, {0, 1}), {Vec3(0, 0, 0), Vec3(30, 0, 0), Vec3(30, 10, 0), Vec3(1, 10, 0)}, {}};
  const Vec3 p(3, 7, 0);
  const auto far = nearest_on(shoe, p), local = foot_near(shoe, p, 0.0);
  CHECK(local.u < 0.2);
  CHECK(far.u > 0.8);
  CHECK(far.distance < local.distance - 1);
}

}  // namespace partscribe::geometry
