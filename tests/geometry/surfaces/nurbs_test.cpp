#include "geometry/surfaces/nurbs.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/number.h"

namespace partscribe::geometry {
namespace {

const KnotVector uneven{3, {0, 0, 0, 0, 0.2, 0.5, 0.5, 0.7, 0.7, 0.7, 1, 1, 1, 1}};

NurbsSurface wavy(bool rational) {
  NurbsSurface s{clamped(3, {0, 0.3, 1}), clamped(2, {-1, 0, 0.5, 2}), {}, {}};
  for (int i = 0; i < s.u.count(); ++i)
    for (int j = 0; j < s.v.count(); ++j) {
      s.points.emplace_back(10 * i, 8 * j, 5 * std::sin(1.3 * i) * std::cos(0.9 * j));
      if (rational) s.weights.push_back(1 + 0.5 * std::sin(double(i + 2 * j)));
    }
  return s;
}

/// The circle of radius 1 as four rational quadratic arcs.
NurbsCurve<2> circle() {
  NurbsCurve<2> c{{2, {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4}}, {}, {}};
  for (int k = 0; k <= 8; ++k) {
    const double angle = k * pi / 4, radius = k % 2 ? std::sqrt(2.0) : 1;
    c.points.push_back(radius * Vec2(std::cos(angle), std::sin(angle)));
    c.weights.push_back(k % 2 ? std::sqrt(0.5) : 1);
  }
  return c;
}

}  // namespace

TEST_CASE("nurbs: basis functions add up to one at every knot and between them") {
  for (const int degree : {1, 2, 3, 5}) {
    KnotVector knots = clamped(degree, {0, 0.1, 0.4, 0.4, 1});
    std::vector<double> places = knots.breaks();
    for (int i = 0; i <= 40; ++i) places.push_back(i / 40.0);
    for (const double t : places) {
      BasisValues n;
      basis(knots, t, 2, n);
      double sum[3] = {};
      for (int d = 0; d < 3; ++d)
        for (int i = 0; i <= degree; ++i) sum[d] += n.value[d][i];
      CHECK(sum[0] == Approx(1).margin(1e-14));
      CHECK(sum[1] == Approx(0).margin(1e-10));
      CHECK(sum[2] == Approx(0).margin(1e-8));
      for (int i = 0; i <= degree; ++i) CHECK(n.value[0][i] >= 0);
    }
  }
}

TEST_CASE("nurbs: spans are half open, the last one is closed, and empty ones hold nothing") {
  CHECK(uneven.span(0) == 3);
  CHECK(uneven.span(0.2) == 4);
  CHECK(uneven.span(0.5) == 6);
  CHECK(uneven.span(0.7) == 9);
  CHECK(uneven.span(std::nextafter(1, 0)) == 9);
  CHECK(uneven.span(1) == 9);
  CHECK(uneven.multiplicities() == std::vector<std::pair<double, int>>{{0, 4}, {0.2, 1}, {0.5, 2}, {0.7, 3}, {1, 4}});
  CHECK(uneven.breaks() == std::vector<double>{0, 0.2, 0.5, 0.7, 1});
  CHECK(clamped(3, {0, 1}).knots == std::vector<double>{0, 0, 0, 0, 1, 1, 1, 1});
}

TEST_CASE("nurbs: a curve begins and ends in its control points, stays in their hull and changes only near one") {
  NurbsCurve<2> c{uneven, {}, {}};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-5, 5);
  for (int i = 0; i < uneven.count(); ++i) c.points.emplace_back(coordinate(random), coordinate(random));
  CHECK((c.at(0) - c.points.front()).norm() < 1e-14);
  CHECK((c.at(1) - c.points.back()).norm() < 1e-14);
  CHECK((c.at(0.7) - c.points[6]).norm() < 1e-14);  // a knot of multiplicity 3
  NurbsCurve<2> other = c;
  other.points[3] += Vec2(1, 2);
  for (int i = 0; i <= 200; ++i) {
    const double t = i / 200.0;
    for (int k = 0; k < 16; ++k) {
      const Vec2 direction(std::cos(k * pi / 8), std::sin(k * pi / 8));
      double most = -1e300;
      for (const auto& p : c.points) most = std::max(most, p.dot(direction));
      CHECK(c.at(t).dot(direction) <= most + 1e-12);
    }
    const bool lives = t > uneven.knots[3] && t < uneven.knots[7];
    CHECK(((other.at(t) - c.at(t)).norm() > 1e-12) == lives);
  }
}

TEST_CASE("nurbs: four rational quadratic arcs are a circle, with the circle's derivatives") {
  const auto c = circle();
  for (int i = 0; i <= 100; ++i) {
    Vec2 p, d1, d2;
    c.derivatives(i / 25.0, p, d1, d2);
    CHECK(p.norm() == Approx(1).margin(1e-14));
    CHECK(p.dot(d1) == Approx(0).margin(1e-13));
    CHECK(p.dot(d2) + d1.squaredNorm() == Approx(0).margin(1e-12));  // (p . p)'' = 0
  }
}

TEST_CASE("nurbs: derivatives of a surface are those that differences show") {
  for (const bool rational : {false, true}) {
    const NurbsSurface s = wavy(rational);
    for (const double u : {0.0, 0.11, 0.3, 0.84, 1.0})
      for (const double v : {-1.0, -0.4, 0.2, 1.1, 2.0}) {
        // Differences taken inwards, so that no knot lies between.
        const double h = 1e-5, hu = u < 0.9 ? h : -h, hv = v < 1.9 ? h : -h;
        const auto at = s.derivatives(u, v);
        const auto du = [&](double b) { return (s.derivatives(u + hu, b).p - s.derivatives(u, b).p) / hu; };
        CHECK((at.p - s.at(u, v)).norm() < 1e-12);
        CHECK((s.at(u + hu, v) - at.p - hu * at.du - 0.5 * hu * hu * at.duu).norm() < 1e-9);
        CHECK((s.at(u, v + hv) - at.p - hv * at.dv - 0.5 * hv * hv * at.dvv).norm() < 1e-9);
        CHECK(((du(v + hv) - du(v)) / hv - at.duv).norm() < 2e-2 * (1 + at.duv.norm()));
      }
  }
}

TEST_CASE("nurbs: a curve and a surface stay what they are when knots are inserted") {
  const auto c = circle();
  const auto finer = with_knot(with_knot(c, 0.3, 2), 1.0);  // at 1 there are two already
  CHECK(finer.points.size() == c.points.size() + 3);
  for (int i = 0; i <= 100; ++i) CHECK((finer.at(i / 25.0) - c.at(i / 25.0)).norm() < 1e-13);
  for (const bool rational : {false, true}) {
    const NurbsSurface s = wavy(rational);
    const NurbsSurface more = with_knot(with_knot(s, true, 0.5, 3), false, 0.0);
    CHECK(more.u.count() == s.u.count() + 3);
    CHECK(more.v.count() == s.v.count() + 1);
    for (int i = 0; i <= 20; ++i)
      for (int j = 0; j <= 20; ++j)
        CHECK((more.at(i / 20.0, -1 + 3 * j / 20.0) - s.at(i / 20.0, -1 + 3 * j / 20.0)).norm() < 1e-11);
  }
}

TEST_CASE(
    "nurbs: the foot of a point lifted off a surface is where it was lifted, and on the border for those beyond") {
  for (const bool rational : {false, true}) {
    const NurbsSurface s = wavy(rational);
    for (int i = 1; i < 10; ++i)
      for (int j = 1; j < 10; ++j) {
        const double u = i / 10.0, v = -1 + 3 * j / 10.0;
        const auto at = s.derivatives(u, v);
        const auto foot = foot_near(s, at.p + 0.7 * at.normal(), u + 0.04, v - 0.07);
        CHECK(foot.distance == Approx(0.7).epsilon(1e-9));
        CHECK((foot.point - at.p).norm() < 1e-5);
      }
    const auto corner = foot_near(s, s.points.front() - Vec3(5, 6, 0), 0.2, 0.0);
    CHECK(corner.u == 0);
    CHECK(corner.v == -1);
  }
}

}  // namespace partscribe::geometry
