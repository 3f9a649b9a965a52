#include "fit/surface/spline_fit.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"

using namespace partscribe::core;
using namespace partscribe::geometry;
using namespace partscribe::fit;

namespace {

template <class Height>
SplineData scattered(const Height& height, std::size_t count, double noise, unsigned seed) {
  Random random(seed);
  SplineData data;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = 60 * random.uniform(), y = 40 * random.uniform();
    data.points.emplace_back(x, y, height(x, y) + noise * random.normal());
    data.places.emplace_back(x, y);
  }
  return data;
}

/// mm, the largest distance of the true surface from a fit.
template <class Height>
double true_error(const SplineFit& fit, const Height& height) {
  double worst = 0;
  for (int i = 0; i <= 60; ++i)
    for (int j = 0; j <= 40; ++j) {
      const Vec3 p(0.5 + 59.0 * i / 60, 0.5 + 39.0 * j / 40, 0);
      const Vec3 on(p.x(), p.y(), height(p.x(), p.y()));
      worst = std::max(worst, foot_near(fit.surface, on, p.x(), p.y()).distance);
    }
  return worst;
}

SplineFitOptions options_for(double tolerance, double noise = 0) {
  SplineFitOptions options;
  options.tolerance = tolerance, options.noise = noise;
  options.low = Vec2(-0.5, -0.5), options.high = Vec2(60.5, 40.5);
  return options;
}

const auto cubic = [](double x, double y) { return 1e-4 * x * x * x - 0.01 * x * y + 0.002 * y * y; };
const auto wave = [](double x, double y) { return 6 * std::sin(x / 12) * std::cos(y / 15); };

}  // namespace

TEST_CASE("spline fit: a bicubic surface needs 4 x 4 control points and is met exactly") {
  Context context;
  const auto data = scattered(cubic, 3000, 0, 1);
  const auto fit = fit_spline(data, options_for(0.05), context);
  REQUIRE(fit);
  CHECK(fit->surface.points.size() == 16);
  CHECK(true_error(*fit, cubic) < 0.05);  // the rest is the price of fairness
}

TEST_CASE("spline fit: the tolerance is kept, and half of it costs more control points") {
  Context context;
  const auto data = scattered(wave, 12000, 0, 2);
  std::size_t before = 0;
  for (const double tolerance : {0.2, 0.02, 0.002}) {
    const auto fit = fit_spline(data, options_for(tolerance), context);
    REQUIRE(fit);
    CHECK(fit->worst <= tolerance);
    CHECK(true_error(*fit, wave) < 1.5 * tolerance);
    CHECK(fit->surface.points.size() > before);
    CHECK(fit->surface.points.size() < 1000);
    before = fit->surface.points.size();
  }
}

TEST_CASE("spline fit: surfaces are cubic both ways at any tolerance, and bend on across every knot") {
  Context context;
  const auto data = scattered(wave, 12000, 0, 2);
  for (const double tolerance : {0.2, 0.005}) {
    const auto fit = fit_spline(data, options_for(tolerance), context);
    REQUIRE(fit);
    for (const KnotVector* knots : {&fit->surface.u, &fit->surface.v}) {
      CHECK(knots->degree == 3);  // order four
      for (const auto& [at, times] : knots->multiplicities())
        CHECK(times == (at == knots->low() || at == knots->high() ? 4 : 1));
    }
  }
}

TEST_CASE("spline fit: noise is averaged, not followed") {
  Context context;
  const auto data = scattered(wave, 20000, 0.03, 3);
  const auto fit = fit_spline(data, options_for(0.05, 0.03), context);
  REQUIRE(fit);
  CHECK(true_error(*fit, wave) < 0.05);
  CHECK(fit->surface.points.size() < 260);
}

TEST_CASE("spline fit: detail in one place does not refine all of the surface") {
  Context context;
  const auto bump = [](double x, double y) { return 3 * std::exp(-((x - 45) * (x - 45) + (y - 30) * (y - 30)) / 8); };
  const auto fit = fit_spline(scattered(bump, 20000, 0, 4), options_for(0.05), context);
  REQUIRE(fit);
  CHECK(true_error(*fit, bump) < 0.08);
  const auto us = fit->surface.u.breaks();
  std::size_t near = 0;
  for (const double u : us) near += u > 33 && u < 57;
  CHECK(near > us.size() / 2);
}

TEST_CASE("spline fit: a crease is one triple knot in its place, and the surface is sharp there") {
  Context context;
  const auto fold = [](double x, double y) { return 0.3 * std::abs(x - 23.7) + 2 * std::sin(y / 15); };
  for (const double noise : {0.0, 0.03}) {
    const auto fit = fit_spline(scattered(fold, 20000, noise, 7), options_for(0.05, noise), context);
    REQUIRE(fit);
    CHECK(true_error(*fit, fold) < 0.05);
    CHECK(fit->surface.points.size() < 50);
    int triple = 0;
    for (const auto& [at, times] : fit->surface.u.multiplicities())
      if (at > 0 && at < 60) triple += times == 3 && std::abs(at - 23.7) < 0.03;
    CHECK(triple == 1);
    // Feet on the ridge, from both sides of it.
    for (const double start : {20.0, 23.6, 23.8, 28.0}) {
      const Vec3 below(23.7, 20, fold(23.7, 20) - 2);
      CHECK(foot_near(fit->surface, below, start, 20).distance == Approx(2).margin(0.05));
    }
  }
}

TEST_CASE("spline fit: what is rougher than its points allow is refused") {
  Context context;
  CHECK_FALSE(fit_spline(scattered(wave, 4000, 1.0, 5), options_for(0.01), context));
  CHECK_FALSE(fit_spline(scattered(wave, 10, 0, 6), options_for(0.1), context));
}
