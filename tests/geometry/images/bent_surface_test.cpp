#include "geometry/images/bent_surface.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace partscribe::geometry;

namespace {

Tilt tilt_of(double slope_x, double slope_y) {
  const double tangent = std::hypot(slope_x, slope_y);
  const auto f = [](double v) { return static_cast<float>(v); };
  return {f(slope_x / tangent), f(slope_y / tangent), f(tangent), f(std::sqrt(1 + tangent * tangent))};
}

/// A sphere of radius r with its middle r above the image: depth, and slope and bend by differences.
struct Ball {
  double r;
  double depth(double x, double y) const { return -std::sqrt(r * r - x * x - y * y); }
  Bend bend(double x, double y) const {
    const double e = 1e-3 * r, z = depth(x, y);
    const auto second = [&](double dx, double dy) {
      return (depth(x + dx, y + dy) - 2 * z + depth(x - dx, y - dy)) / (2 * e * e);
    };
    const double xx = second(e, 0), yy = second(0, e);
    return {static_cast<float>(xx), static_cast<float>(yy), static_cast<float>(second(e, e) - xx - yy)};
  }
  Tilt tilt(double x, double y) const { return tilt_of(-x / depth(x, y), -y / depth(x, y)); }
};

}  // namespace

TEST_CASE("bent surface: a ball has one curvature wherever it is seen") {
  const Ball ball{50};
  for (const auto& [x, y] : {std::pair{5.0, 0.0}, {20.0, 10.0}, {-30.0, 25.0}, {0.0, 45.0}}) {
    const Tilt tilt = ball.tilt(x, y);
    const Bend k = curvature_of(ball.bend(x, y), tilt), back = bend_of(k, tilt);
    CHECK(k.xx == Approx(0.01).epsilon(1e-3));
    CHECK(k.yy == Approx(0.01).epsilon(1e-3));
    CHECK(k.xy == Approx(0).margin(1e-5));
    CHECK((back - ball.bend(x, y)).evidence() < 1e-8F);
  }
}

TEST_CASE("bent surface: along its tilt it is an arc up to the fourth order") {
  const double r = 45;
  for (const double x0 : {0.0, 20.0, 36.0, 40.0})
    for (const double unit : {1.0, 0.01}) {  // pixels per height
      const double z0 = -std::sqrt(r * r - x0 * x0), slope = -x0 / z0, cos3 = std::pow(-z0 / r, 3);
      const Bend bend{static_cast<float>(0.5 / (r * cos3) / unit), 0, 0};
      const BentSurface shape(bend, x0 == 0 ? Tilt{} : tilt_of(slope, 0), static_cast<float>(unit));
      double sum = 0, fitted = 0;
      for (int x = -2; x <= 2; ++x) {
        const double truth = (-std::sqrt(r * r - (x0 + x) * (x0 + x)) - z0 - slope * x) / unit;
        const double fifth = std::pow(2 / (r * (1 - x0 / r)), 3) * r / unit;  // what is left out
        CHECK(shape.at(static_cast<float>(x), 1) == Approx(truth).margin(0.02 * fifth + 1e-5 / unit));
        sum += static_cast<double>(shape.at(static_cast<float>(x), 0)), fitted += x * truth;
      }
      CHECK(shape.mean() == Approx(sum / 5));
      CHECK(shape.steepening() == Approx(fitted / 10).margin(0.02 * fitted + 1e-5 / unit));
      const auto [along, across] = shape.slope(1, 0);
      CHECK(along == Approx(((x0 + 1) / std::sqrt(r * r - (x0 + 1) * (x0 + 1)) - slope) / unit).epsilon(0.02));
      CHECK(across == 0);
    }
}

TEST_CASE("bent surface: without a bend there is nothing but the tangent plane") {
  const BentSurface flat;
  CHECK(flat.flat());
  CHECK(flat.at(2, -1) == 0);
  CHECK(flat.mean() == 0);
}
