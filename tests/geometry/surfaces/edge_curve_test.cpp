#include "geometry/surfaces/edge_curve.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace partscribe::geometry {
namespace {

NurbsCurve<2> line(const Vec2& a, const Vec2& b) { return {clamped(1, {0, 2}), {a, b}, {}}; }

/// z = height + x^2 / 40 over (0 .. 20) x (0 .. 10), u and v in mm.
NurbsSurface arch(double height) {
  NurbsSurface s{clamped(2, {0, 20}), clamped(1, {0, 10}), {}, {}};
  const double z[] = {0, 0, 10};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 2; ++j) s.points.emplace_back(10 * i, 10 * j, height + z[i]);
  return s;
}

}  // namespace

TEST_CASE("edge curve: it is the mean of its sides at equal shares, and has their derivative") {
  const NurbsSurface lower = arch(0), upper = arch(0.2);
  const NurbsCurve<2> forth = line({0, 10}, {20, 10}), back = line({20, 0}, {0, 0});
  const EdgeSide sides[] = {{&lower, &forth}, {&upper, &back}};
  for (const double share : {0.0, 0.3, 0.5, 1.0}) {
    Vec3 place, derivative;
    edge_place(sides, share, share > 0.5, place, derivative);
    const double x = 20 * share;
    CHECK((place - Vec3(x, 5, 0.1 + x * x / 40)).norm() < 1e-9);
    CHECK((derivative - Vec3(20, 0, 20 * x / 20)).norm() < 1e-6);
  }
  CHECK(edge_gap(sides, 10) == Approx(std::hypot(10, 0.2)));
  CHECK(edge_gap(std::span(sides, 1), 10) == 0);
  const auto curve = edge_curve(sides, 1e-6);
  for (int i = 0; i <= 50; ++i) {
    const double x = 20 * i / 50.0;
    CHECK((curve.at(i / 50.0) - Vec3(x, 5, 0.1 + x * x / 40)).norm() < 1e-6);
  }
}

TEST_CASE("edge curve: it is halved until it is near enough, and keeps kinks") {
  const NurbsSurface surface = arch(0);
  const NurbsCurve<2> bent{clamped(1, {0, 1, 3}), {{1, 1}, {19, 1}, {19, 9}}, {}};
  const EdgeSide side[] = {{&surface, &bent}};
  const auto curve = edge_curve(side, 0.001);
  for (int i = 0; i <= 90; ++i) {
    Vec3 place, derivative;
    edge_place(side, i / 90.0, false, place, derivative);
    CHECK((curve.at(i / 90.0) - place).norm() < 0.001);
  }
  CHECK(curve.t.multiplicities()[1].second == 3);  // at the corner, which is at a third
  CHECK(curve.t.multiplicities()[1].first == Approx(1 / 3.0));
}

}  // namespace partscribe::geometry
