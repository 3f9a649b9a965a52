#include "fit/surface/published_spline.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"

using namespace partscribe::geometry;
using namespace partscribe::fit;

namespace {

/// A step, a slope and a wave over 0 .. 100.
std::vector<Vec3> wavy_profile(bool step) {
  std::vector<Vec3> places;
  for (int i = 0; i <= 400; ++i) {
    const double x = 0.25 * i;
    places.emplace_back(x, 0, 6 * std::sin(x / 9) + (step && x >= 50 ? 20 : 0));
  }
  return places;
}

PlaceGrid wavy_grid(int columns, int rows) {
  PlaceGrid grid{columns, rows, {}};
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const double x = 80.0 * c / (columns - 1), y = 60.0 * r / (rows - 1);
      grid.places.emplace_back(x, y, 4 * std::sin(x / 7) * std::cos(y / 11));
    }
  return grid;
}

}  // namespace

TEST_CASE("published spline: chord lengths, their roots and equal steps go from 0 to 1") {
  const std::vector<Vec3> places = {{0, 0, 0}, {1, 0, 0}, {1, 9, 0}};
  const auto chord = parameters_of(places, Parameters::chord_length);
  CHECK(chord == std::vector<double>{0, 0.1, 1});
  CHECK(parameters_of(places, Parameters::uniform) == std::vector<double>{0, 0.5, 1});
  CHECK(parameters_of(places, Parameters::centripetal) == std::vector<double>{0, 0.25, 1});
  for (const double t : parameters_of({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, Parameters::chord_length))
    CHECK(std::isfinite(t));
}

TEST_CASE("published spline: a curve whose control points are known is found again by least squares") {
  NurbsCurve<3> truth;
  truth.t = equal_spans(7);
  Random random(4);
  for (int i = 0; i < 7; ++i) truth.points.emplace_back(10 * i, 10 * random.uniform(), 10 * random.uniform());
  std::vector<Vec3> places;
  std::vector<double> at;
  for (int i = 0; i <= 60; ++i) at.push_back(i / 60.0), places.push_back(truth.at(at.back()));
  const auto fit = published_curve(places, at, truth.t);
  for (std::size_t i = 0; i < 7; ++i) CHECK((fit.curve.points[i] - truth.points[i]).norm() < 1e-5);
  CHECK(fit.worst < 1e-5);
  // Noise: the residuals are square to every basis function, as the normal equations say.
  for (Vec3& p : places) p += 0.1 * Vec3(random.normal(), random.normal(), random.normal());
  const auto noisy = published_curve(places, at, truth.t);
  std::vector<Vec3> sums(7, Vec3::Zero());
  BasisValues b;
  for (std::size_t i = 0; i < places.size(); ++i) {
    basis(truth.t, at[i], 0, b);
    for (int k = 0; k <= 3; ++k) sums[std::size_t(b.first + k)] += b.value[0][k] * (places[i] - noisy.curve.at(at[i]));
  }
  for (const Vec3& sum : sums) CHECK(sum.norm() < 1e-5);
}

TEST_CASE(
    "published spline: knots at the largest errors bring a profile within the tolerance, each adds a control point") {
  const auto places = wavy_profile(false);
  const auto at = parameters_of(places, Parameters::chord_length);
  const auto rough = published_curve(places, at, equal_spans(6));
  CHECK(rough.worst > 1);
  const auto fine = refined_curve(places, at, equal_spans(6), 0.05);
  CHECK(fine.worst <= 0.05);
  CHECK(fine.curve.points.size() < 60);
  CHECK(fine.curve.t.count() == int(fine.curve.points.size()));
  CHECK(fine.curve.t.knots.size() - rough.curve.t.knots.size() == fine.curve.points.size() - rough.curve.points.size());
  const auto coarser = refined_curve(places, at, equal_spans(6), 0.5);
  CHECK(coarser.curve.points.size() < fine.curve.points.size());
}

TEST_CASE("published spline: four knots at one place let a cubic jump where the profile does") {
  const auto places = wavy_profile(true);
  const auto at = parameters_of(places, Parameters::uniform);
  const double jump = 0.5 * (at[199] + at[200]);
  const auto smooth = published_curve(places, at, equal_spans(24));
  const auto split = published_curve(places, at, with_gap(equal_spans(24), jump));
  CHECK(smooth.worst > 3);
  CHECK(split.worst < 0.05);
  CHECK(with_gap(equal_spans(8), 0.3).knots.size() == equal_spans(8).knots.size() + 4);
  CHECK(with_gap(with_gap(equal_spans(8), 0.3), 0.3) == with_gap(equal_spans(8), 0.3));
  // Both ends of the gap are control points.
  CHECK((split.curve.at(jump - 1e-12) - split.curve.at(jump)).norm() > 15);
}

TEST_CASE("published spline: two banded solves give the least squares of the whole net") {
  PlaceGrid grid = wavy_grid(33, 27);
  Random random(9);
  for (Vec3& p : grid.places) p.z() += 0.2 * random.normal();
  const auto fit = published_surface(grid, equal_spans(9), equal_spans(7, 3), Parameters::uniform);
  CHECK(fit.surface.points.size() == 63);
  std::vector<Vec3> sums(63, Vec3::Zero());
  BasisValues bu, bv;
  for (int r = 0; r < grid.rows; ++r)
    for (int c = 0; c < grid.columns; ++c) {
      const double u = fit.u[std::size_t(c)], v = fit.v[std::size_t(r)];
      basis(fit.surface.u, u, 0, bu), basis(fit.surface.v, v, 0, bv);
      const Vec3 off = grid.at(c, r) - fit.surface.at(u, v);
      CHECK(off.norm() == Approx(fit.errors[std::size_t(r * grid.columns + c)]));
      for (int i = 0; i <= 3; ++i)
        for (int j = 0; j <= 2; ++j)
          sums[std::size_t((bu.first + i) * 7 + bv.first + j)] += bu.value[0][i] * bv.value[0][j] * off;
    }
  for (const Vec3& sum : sums) CHECK(sum.norm() < 1e-4);
}

TEST_CASE("published spline: a grid is refined in the columns and rows where it fails") {
  const PlaceGrid grid = wavy_grid(120, 90);
  const auto start = equal_spans(5);
  for (const auto kind : {Parameters::uniform, Parameters::chord_length, Parameters::centripetal}) {
    const auto fit = refined_surface(grid, start, start, kind, 0.02);
    CHECK(fit.worst <= 0.02);
    CHECK(fit.surface.points.size() < 2000);
    CHECK(*std::max_element(fit.errors.begin(), fit.errors.end()) == fit.worst);
  }
}

TEST_CASE("published spline: spans without data keep straight and nothing is refined for ever") {
  std::vector<Vec3> places;
  for (int i = 0; i <= 20; ++i) places.emplace_back(i < 10 ? i : 100 + i, 0, i < 10 ? 0 : 1);
  const auto at = parameters_of(places, Parameters::chord_length);
  const auto fit = published_curve(places, at, equal_spans(16));
  for (const Vec3& p : fit.curve.points) CHECK(p.allFinite());
  for (int i = 0; i <= 100; ++i) CHECK(std::abs(fit.curve.at(i / 100.0).z() - 0.5) < 1.5);
  const auto refined = refined_curve(places, at, equal_spans(4), 1e-12);
  CHECK(refined.curve.t.count() <= 40);
}
