#include "geometry/surfaces/nurbs_weights.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/number.h"
#include "geometry/surfaces/nurbs_exact.h"

namespace partscribe::geometry {
namespace {

/// Quadratic pieces that meet smoothly only if the control points say so, from the tangents of a rough polygon.
NurbsCurve<2> rough_start(const NurbsCurve<2>& exact, double off, unsigned seed) {
  NurbsCurve<2> start{exact.t, exact.points, {}};
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-off, off);
  for (std::size_t i = 1; i + 1 < start.points.size(); ++i) {
    const double x = shift(random), y = shift(random);
    start.points[i] += Vec2(x, y);
  }
  return start;
}

std::vector<Vec2> samples_of(const NurbsCurve<2>& curve, int count) {
  std::vector<Vec2> places;
  for (int i = 0; i <= count; ++i)
    places.push_back(curve.at(curve.t.low() + (curve.t.high() - curve.t.low()) * i / count));
  return places;
}

}  // namespace

TEST_CASE("nurbs_weights: points of a conic give its weighted control points, however rough the start") {
  const std::vector<NurbsCurve<2>> conics = {exact_arc({Vec2(3, 4), 10, 0.3, 1.7}),
                                             exact_arc({Vec2::Zero(), 10, 0, 3 * pi / 2}),
                                             exact_ellipse(Vec2(1, 1), Vec2(12, 2), Vec2(-1, 5), 0.2, 3.1),
                                             exact_hyperbola(Vec2::Zero(), Vec2(4, 0), Vec2(0, 6), -0.4, 0.5)};
  for (unsigned k = 0; k < conics.size(); ++k) {
    const auto fit = with_fitted_weights(rough_start(conics[k], 0.7, k), samples_of(conics[k], 100));
    CHECK(fit.largest < 1e-6);
    CHECK(fit.rms <= fit.largest);
    CHECK(fit.curve.points.size() == conics[k].points.size());
    CHECK(fit.curve.weights.front() == 1);
    for (const double w : fit.curve.weights) CHECK(w > 0);
  }
}

TEST_CASE("nurbs_weights: three quarters of a circle are seven control points, round by their weights") {
  const Arc2 arc{Vec2::Zero(), 10, 0, 3 * pi / 2};
  const auto exact = exact_arc(arc);
  const auto places = samples_of(exact, 200);
  const auto fit = with_fitted_weights(rough_start(exact, 0.3, 5), places);
  CHECK(fit.curve.points.size() == 7);
  for (int i = 0; i <= 300; ++i) CHECK(fit.curve.at(exact.t.high() * i / 300).norm() == Approx(10).margin(1e-6));
  // The same control points without their weights are off by tenths.
  double off = 0;
  const NurbsCurve<2> bare{fit.curve.t, fit.curve.points, {}};
  for (int i = 0; i <= 300; ++i) off = std::max(off, std::abs(bare.at(exact.t.high() * i / 300).norm() - 10));
  CHECK(off > 0.3);
}

TEST_CASE("nurbs_weights: noise is averaged, and ends stay where they were") {
  const auto exact = exact_arc({Vec2::Zero(), 10, 0, 2});
  auto places = samples_of(exact, 400);
  std::mt19937 random(9);
  std::normal_distribution<double> noise(0, 0.05);
  for (Vec2& p : places) {
    const double x = noise(random), y = noise(random);
    p += Vec2(x, y);
  }
  const auto start = rough_start(exact, 0.5, 6);
  const auto fit = with_fitted_weights(start, places);
  CHECK(fit.curve.points.front() == start.points.front());
  CHECK(fit.curve.points.back() == start.points.back());
  CHECK(fit.rms == Approx(0.05).epsilon(0.1));  // one of two components of the noise is across
  for (int i = 0; i <= 50; ++i) CHECK(fit.curve.at(2 * i / 50.0).norm() == Approx(10).margin(0.03));
}

TEST_CASE("nurbs_weights: a fit in space does not depend on where the curve lies") {
  const auto exact = exact_arc({Vec2(3, 4), 10, 0.3, 1.7});
  const Pose pose{rotation_of(Vec3(0.5, -1, 0.3)), Vec3(20, -30, 5)};
  const auto flat = rough_start(exact, 0.7, 2);
  NurbsCurve<3> start{flat.t, {}, {}};
  for (const Vec2& p : flat.points) start.points.push_back(pose * Vec3(p.x(), p.y(), 0));
  std::vector<Vec3> places;
  for (const Vec2& p : samples_of(exact, 100)) places.push_back(pose * Vec3(p.x(), p.y(), 0));
  const auto fit = with_fitted_weights(start, places);
  CHECK(fit.largest < 1e-6);
  const Vec3 center = pose * Vec3(3, 4, 0);
  for (int i = 0; i <= 50; ++i) CHECK((fit.curve.at(1.4 * i / 50) - center).norm() == Approx(10).margin(1e-6));
}

}  // namespace partscribe::geometry
