#include "fit/surface/piece_fit.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "fit/input/prepare.h"

using namespace partscribe::core;
using namespace partscribe::fit;

namespace {

FitInput input_of(double tolerance) {
  FitInput input;
  input.tolerance = tolerance;
  return input;
}

SplineData dome() {
  SplineData data;
  for (int i = 0; i <= 40; ++i)
    for (int j = 0; j <= 30; ++j) {
      data.points.emplace_back(i, j, 3 * std::sin(i / 12.0) * std::sin(j / 10.0));
      data.places.emplace_back(i, j);
    }
  return data;
}

}  // namespace

TEST_CASE("piece fit: a point of a triangle goes where the layout of its corners says") {
  const TriangleMesh mesh{{{0, 0, 0}, {10, 0, 5}, {0, 10, 0}}, {{0, 1, 2}}};
  const std::vector<Vec2> places = {{1, 1}, {3, 1}, {1, 5}};
  const Vec3 p =
      mesh.vertices[0] + 0.25 * (mesh.vertices[1] - mesh.vertices[0]) + 0.5 * (mesh.vertices[2] - mesh.vertices[0]);
  CHECK((place_on(mesh, places, 0, p) - Vec2(1.5, 3)).norm() < 1e-12);
}

TEST_CASE("piece fit: the domain is whole steps, and places on an edge are met more closely than others") {
  Context context;
  const FitInput input = input_of(0.1);
  const SplineData data = dome();
  const auto fit = fit_piece(data, input, context);
  REQUIRE(fit);
  for (const double end : {fit->surface.u.low(), fit->surface.u.high(), fit->surface.v.low(), fit->surface.v.high()})
    CHECK(end == Approx(snapped(end, 0.001)).margin(1e-12));
  CHECK(fit->worst < 0.07);

  // An edge at u = 20 that lies 0.03 higher than the points.
  SplineData held = data;
  held.places = fit->places;
  held.weights.assign(held.points.size(), 1);
  for (int j = 2; j < 29; ++j) {
    const auto at = fit->surface.derivatives(20, j);
    held.points.push_back(at.p + 0.03 * at.normal()), held.places.emplace_back(20, j), held.weights.push_back(50);
    ++held.held;
  }
  const auto again = fit_piece_again(held, fit->surface, 0.01, input, context);
  REQUIRE(again);
  for (std::size_t i = data.points.size(); i < held.points.size(); ++i)
    CHECK((again->surface.at(again->places[i].x(), again->places[i].y()) - held.points[i]).norm() < 0.011);
}

TEST_CASE("piece fit: numbers are rounded so that nothing moves by more than a fiftieth of the tolerance") {
  TrimmedSurface trimmed{
      {clamped(1, {0, 10}), clamped(1, {0, 10}), {{0.123456, 0, 0}, {0, 10, 0}, {10, 0, 0}, {10, 10, 0}}, {}},
      {{{{clamped(1, {0, 1}), {{0.98765, 1}, {9, 1}}, {}}, 1}}}};
  round_numbers(trimmed, 0.5);
  CHECK(trimmed.surface.points[0].x() == Approx(0.12));
  CHECK(trimmed.loops[0][0].curve.points[0].x() == Approx(0.99));
}

TEST_CASE("piece fit: a point of a triangle without area has a place as well") {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {2, 0, 0}, {1, 1e-13, 0}, {0, 0, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 0}};
  const std::vector<Vec2> places = {{0, 0}, {2, 0}, {1, 0}, {0, 0}};
  for (const std::size_t t : {0u, 1u}) {
    const Vec2 at = place_on(mesh, places, t, Vec3(1.5, 1e-9, 0));
    CHECK(at.allFinite());
    CHECK(at.norm() < 10);
  }
}
