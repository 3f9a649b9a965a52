#include "fit/surface/curve_fit.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace partscribe::geometry;
using namespace partscribe::fit;

TEST_CASE("curve fit: what is straight is a line, an arc in space a cubic of few pieces within the tolerance") {
  std::vector<Vec3> line, arc;
  for (int i = 0; i <= 50; ++i) {
    line.emplace_back(i, 2 * i, 0.001 * (i % 2));
    arc.emplace_back(20 * std::cos(i / 25.0), 20 * std::sin(i / 25.0), 0.1 * i);
  }
  CHECK(fitted_curve<3>(line, 0.01).t.degree == 1);
  const auto curve = fitted_curve<3>(arc, 0.01);
  CHECK(curve.t.degree == 3);
  CHECK(curve.points.size() <= 8);
  CHECK(curve.at(0) == arc.front());
  CHECK(curve.at(1) == arc.back());
  for (int i = 0; i <= 100; ++i) CHECK(curve.at(i / 100.0).head<2>().norm() == Approx(20).margin(0.015));
}

TEST_CASE("curve fit: parameters that are given are kept") {
  std::vector<Vec2> places;
  std::vector<double> at;
  for (int i = 0; i <= 20; ++i) {
    at.push_back(i / 20.0);
    places.emplace_back(at.back() * at.back(), std::pow(at.back(), 3));
  }
  const auto curve = curve_through<2>(places, at, clamped(3, {0, 1}));
  for (std::size_t i = 0; i < at.size(); ++i) CHECK((curve.at(at[i]) - places[i]).norm() < 1e-5);
}

TEST_CASE("curve fit: a polyline is made denser and keeps its places") {
  const std::vector<Vec2> corner = {{0, 0}, {1, 0}, {1, 2}};
  CHECK(denser(corner, 0.5).size() == 7);
  CHECK(denser(corner, 5).size() == 3);
  CHECK(denser(corner, 0.5, true).size() == 11);
}
