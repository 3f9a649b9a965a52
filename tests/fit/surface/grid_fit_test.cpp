#include "fit/surface/grid_fit.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"

using namespace partscribe::core;
using namespace partscribe::geometry;
using namespace partscribe::fit;

namespace {

template <class Height>
SplineGrid graph_over(const Height& height, int columns, int rows, double noise = 0) {
  Random random(11);
  SplineGrid grid;
  for (int i = 0; i < columns; ++i) grid.u.push_back(60.0 * i / (columns - 1));
  for (int j = 0; j < rows; ++j) grid.v.push_back(40.0 * j / (rows - 1));
  for (const double x : grid.u)
    for (const double y : grid.v) grid.points.emplace_back(x, y, height(x, y) + noise * random.normal());
  return grid;
}

/// mm, the largest distance of the true graph from a fit, `inset` mm from the border and farther.
template <class Height>
double farthest(const GridFit& fit, const Height& height, double inset = 0) {
  double worst = 0;
  for (int i = 0; i <= 120; ++i)
    for (int j = 0; j <= 80; ++j) {
      const double x = inset + (60 - 2 * inset) * i / 120, y = inset + (40 - 2 * inset) * j / 80;
      const Vec3 on(x, y, height(x, y));
      worst = std::max(worst, foot_near(fit.surface, on, on.x(), on.y()).distance);
    }
  return worst;
}

std::optional<GridFit> fitted(const SplineGrid& grid, double tolerance, double noise = 0) {
  Context context;
  GridFitOptions options;
  options.tolerance = tolerance, options.noise = noise;
  return fit_grid(grid, options, context);
}

const auto wave = [](double x, double y) { return 6 * std::sin(x / 12) * std::cos(y / 15); };
/// Slopes 0.4 and -0.2, folded along x = 23.7.
const auto fold = [](double x, double y) { return (x < 23.7 ? 0.4 : -0.2) * (x - 23.7) + 2 * std::sin(y / 15); };

/// Places of inner knots and how often each is there.
std::vector<std::pair<double, int>> inner(const KnotVector& knots) {
  auto all = knots.multiplicities();
  return {all.begin() + 1, all.end() - 1};
}

}  // namespace

TEST_CASE("grid fit: a bicubic graph needs 4 x 4 control points and is met exactly") {
  const auto cubic = [](double x, double y) { return 1e-4 * x * x * x - 0.01 * x * y + 0.002 * y * y; };
  const auto fit = fitted(graph_over(cubic, 50, 40), 0.05);
  REQUIRE(fit);
  CHECK(fit->surface.points.size() == 16);
  CHECK(farthest(*fit, cubic) < 1e-6);
}

TEST_CASE("grid fit: the tolerance is kept, and a tenth of it costs more control points") {
  std::size_t before = 0;
  for (const double tolerance : {0.2, 0.02, 0.002}) {
    const auto fit = fitted(graph_over(wave, 120, 100), tolerance);
    REQUIRE(fit);
    CHECK(fit->worst <= tolerance);
    CHECK(farthest(*fit, wave) < 1.1 * tolerance);
    CHECK(fit->surface.points.size() > before);
    CHECK(fit->surface.points.size() < 1000);
    before = fit->surface.points.size();
  }
}

TEST_CASE("grid fit: noise is averaged, not followed") {
  const auto clean = fitted(graph_over(wave, 160, 140), 0.05),
             noisy = fitted(graph_over(wave, 160, 140, 0.03), 0.05, 0.03);
  REQUIRE((clean && noisy));
  CHECK(farthest(*noisy, wave, 1) < 0.05);  // the border is half of each mean only
  CHECK(noisy->surface.points.size() < 2 * clean->surface.points.size());
}

TEST_CASE("grid fit: a crease along either direction is one triple knot in its place, with noise as well") {
  const auto turned = [](double x, double y) { return fold(y, x); };
  for (const double noise : {0.0, 0.03}) {
    const auto along_v = fitted(graph_over(fold, 160, 120, noise), 0.05, noise);
    REQUIRE(along_v);
    CHECK(farthest(*along_v, fold, noise > 0 ? 1 : 0) < 0.05);
    const auto knots = inner(along_v->surface.u);
    REQUIRE(knots.size() == 1);
    CHECK(knots[0].second == 3);
    CHECK(std::abs(knots[0].first - 23.7) < (noise > 0 ? 0.03 : 1e-3));
    for (const auto& [at, times] : inner(along_v->surface.v)) CHECK(times == 1);
    const auto along_u = fitted(graph_over(turned, 160, 120, noise), 0.05, noise);
    REQUIRE(along_u);
    CHECK(farthest(*along_u, turned, noise > 0 ? 1 : 0) < 0.05);
    REQUIRE(inner(along_u->surface.v).size() == 1);
    CHECK(inner(along_u->surface.v)[0].second == 3);
    CHECK(std::abs(inner(along_u->surface.v)[0].first - 23.7) < (noise > 0 ? 0.03 : 1e-3));
  }
}

TEST_CASE("grid fit: a bend that is sharp but no crease keeps single knots") {
  const auto bend = [](double x, double) { return 3 * std::tanh((x - 23.7) / 4); };
  const auto fit = fitted(graph_over(bend, 160, 60), 0.01);
  REQUIRE(fit);
  CHECK(farthest(*fit, bend) < 0.011);
  for (const auto& [at, times] : inner(fit->surface.u)) CHECK(times == 1);
  CHECK(fit->surface.v.count() == 4);
}

TEST_CASE("grid fit: surfaces that are no graphs, over lines at uneven distances") {
  const double pi = std::acos(-1);
  SplineGrid grid;
  for (int i = 0; i <= 90; ++i) grid.u.push_back(30 * pi * (i + 0.3 * std::sin(double(i))) / 90);
  for (int j = 0; j <= 60; ++j) grid.v.push_back(0.5 * j + 0.005 * j * j);
  for (const double u : grid.u)
    for (const double v : grid.v) grid.points.emplace_back(30 * std::cos(u / 30), 30 * std::sin(u / 30), v);
  const auto fit = fitted(grid, 0.02);
  REQUIRE(fit);
  CHECK(fit->surface.v.count() == 4);
  double worst = 0;
  for (int i = 0; i <= 200; ++i) {
    const Vec3 p = fit->surface.at(grid.u.back() * i / 200, 11);
    worst = std::max(worst, std::abs(std::hypot(p.x(), p.y()) - 30));
  }
  CHECK(worst <= 0.021);
  CHECK(fit->surface.u.count() < 12);
}

TEST_CASE("grid fit: what is rougher than its points allow is refused") {
  CHECK_FALSE(fitted(graph_over(wave, 60, 50, 1.0), 0.01));
  CHECK_FALSE(fitted(graph_over(wave, 3, 50), 0.01));
}
