#include "geometry/surfaces/nurbs.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/number.h"
#include "geometry/surfaces/nurbs_exact.h"

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

/// Function i of a degree at t by the recursion of Cox and de Boor as it is written, 0 / 0 = 0. The last span of the
/// domain is closed: `span` holds t.
double recursive_basis(const std::vector<double>& k, int i, int degree, double t, int span) {
  if (degree == 0) return i == span ? 1 : 0;
  const auto share = [](double above, double below) { return above == 0 && below == 0 ? 0 : above / below; };
  const double a = recursive_basis(k, i, degree - 1, t, span), b = recursive_basis(k, i + 1, degree - 1, t, span);
  const auto knot = [&](int n) { return k[std::size_t(n)]; };
  return share((t - knot(i)) * a, knot(i + degree) - knot(i)) +
         share((knot(i + degree + 1) - t) * b, knot(i + degree + 1) - knot(i + 1));
}

/// A curve over `t` whose control points are at random.
NurbsCurve<3> random_curve(const KnotVector& t, bool rational, unsigned seed) {
  NurbsCurve<3> c{t, {}, {}};
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-5, 5), weight(0.3, 3);
  for (int i = 0; i < t.count(); ++i) {
    const double x = coordinate(random), y = coordinate(random), z = coordinate(random);
    c.points.emplace_back(x, y, z);
    if (rational) c.weights.push_back(weight(random));
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
        const auto du = [&](double b) { return Vec3((s.derivatives(u + hu, b).p - s.derivatives(u, b).p) / hu); };
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

TEST_CASE("nurbs: basis functions are those of the recursion of Cox and de Boor, in which 0 / 0 is 0") {
  for (int degree = 1; degree <= 7; ++degree)
    for (int times = 1; times <= degree + 1; ++times) {
      KnotVector knots = clamped(degree, {0, 0.25, 0.5, 1.5, 2});
      for (int i = 1; i < times; ++i) knots = with_knot(knots, 0.5);
      std::vector<double> places = knots.breaks();
      for (int i = 0; i <= 32; ++i) places.push_back(i / 16.0);
      for (const double t : places) {
        // The half-open span that holds t; the last one for the end of the domain.
        int span = degree;
        while (span + 1 < knots.count() && !(t < knots.knots[std::size_t(span) + 1])) ++span;
        CHECK(knots.span(t) == span);
        BasisValues n;
        basis(knots, t, 0, n);
        double sum = 0;
        for (int i = 0; i < knots.count(); ++i) {
          const double expected = recursive_basis(knots.knots, i, degree, t, span);
          const bool lives = i >= n.first && i <= n.first + degree;
          CHECK((lives ? n.value[0][i - n.first] : 0.0) == Approx(expected).margin(1e-13));
          sum += expected;
        }
        CHECK(sum == Approx(1).epsilon(1e-13));  // partition of unity at every knot, the last among them
      }
    }
}

TEST_CASE("nurbs: a control point moves a curve only over the knots of its own function, and there everywhere") {
  for (const bool rational : {false, true})
    for (int degree = 1; degree <= 7; ++degree) {
      const auto c = random_curve(clamped(degree, {0, 1, 2, 3, 4, 5, 6, 7, 8}), rational, 1);
      for (std::size_t k = 0; k < c.points.size(); ++k) {
        auto other = c;
        other.points[k] += Vec3(1, -2, 1);
        const double from = c.t.knots[k], to = c.t.knots[k + std::size_t(degree) + 1];
        for (int i = 1; i < 160; i += 2) {
          const double t = i / 20.0;
          const bool moved = (other.at(t) - c.at(t)).norm() > 1e-9 * std::pow(0.02, degree);
          if (t < from || t > to) CHECK(other.at(t) == c.at(t));
          if (t > from + 0.1 && t < to - 0.1) CHECK(moved);
        }
      }
    }
}

TEST_CASE("nurbs: curves and surfaces stay in the hull of the control points of each span") {
  std::mt19937 random(2);
  std::normal_distribution<double> component;
  std::vector<Vec3> directions;
  for (int i = 0; i < 60; ++i) {
    const double x = component(random), y = component(random), z = component(random);
    directions.emplace_back(x, y, z);
  }
  for (const bool rational : {false, true}) {
    for (int degree = 1; degree <= 7; ++degree) {
      const auto c = random_curve(clamped(degree, {0, 1, 2, 3, 4, 5}), rational, 3);
      for (int i = 0; i <= 100; ++i) {
        const double t = i / 20.0;
        const int span = c.t.span(t);
        for (const Vec3& d : directions) {
          double most = -1e300;
          for (int k = span - degree; k <= span; ++k) most = std::max(most, d.dot(c.points[std::size_t(k)]));
          CHECK(d.dot(c.at(t)) <= most + 1e-12);
        }
      }
    }
    const auto s = wavy(rational);
    for (const Vec3& d : directions) {
      double most = -1e300, reached = -1e300;
      for (const Vec3& p : s.points) most = std::max(most, d.dot(p));
      for (int i = 0; i <= 30; ++i)
        for (int j = 0; j <= 30; ++j) reached = std::max(reached, d.dot(s.at(i / 30.0, -1 + j / 10.0)));
      CHECK(reached <= most + 1e-12);
    }
  }
}

TEST_CASE("nurbs: open ends are the first and the last control point, towards their neighbours") {
  for (const bool rational : {false, true})
    for (int degree = 1; degree <= 7; ++degree) {
      const auto c = random_curve(clamped(degree, {-1, 0.5, 2, 7}), rational, 4);
      Vec3 p, d1, d2;
      c.derivatives(-1, p, d1, d2);
      CHECK((p - c.points.front()).norm() < 1e-13);
      CHECK(d1.normalized().dot((c.points[1] - c.points[0]).normalized()) == Approx(1).epsilon(1e-12));
      c.derivatives(7, p, d1, d2);
      CHECK((p - c.points.back()).norm() < 1e-13);
      CHECK(d1.normalized().dot((c.points.back() - c.points[c.points.size() - 2]).normalized()) ==
            Approx(1).epsilon(1e-12));
    }
  for (const bool rational : {false, true}) {
    const auto s = wavy(rational);
    CHECK((s.at(0, -1) - s.points.front()).norm() < 1e-13);
    CHECK((s.at(1, 2) - s.points.back()).norm() < 1e-13);
    CHECK((s.at(0, 2) - s.points[std::size_t(s.v.count()) - 1]).norm() < 1e-13);
  }
}

TEST_CASE("nurbs: a knot as often as the order is a gap, as often as the degree a crease, and less often neither") {
  for (const bool rational : {false, true})
    for (int degree = 1; degree <= 7; ++degree)
      for (int times = 1; times <= degree + 1; ++times) {
        KnotVector t = clamped(degree, {0, 1, 2, 3});
        for (int i = 1; i < times; ++i) t = with_knot(t, 1.0);
        const auto c = random_curve(t, rational, 5);
        Vec3 before, after, d1_before, d1_after, d2;
        c.derivatives(std::nextafter(1.0, 0.0), before, d1_before, d2);
        c.derivatives(1.0, after, d1_after, d2);
        const bool joined = (before - after).norm() < 1e-9;
        const bool smooth = joined && (d1_before - d1_after).norm() < 1e-9 * (1 + d1_after.norm());
        CHECK(joined == (times <= degree));
        CHECK(smooth == (times < degree));
        if (times == degree + 1) {
          // Either side ends in a control point of its own.
          CHECK((before - c.points[std::size_t(degree)]).norm() < 1e-9);
          CHECK((after - c.points[std::size_t(degree) + 1]).norm() < 1e-12);
        }
      }
}

TEST_CASE("nurbs: a surface whose edge is one point evaluates there, and has the normals of its surroundings") {
  const auto sphere = exact_sphere(5);
  for (const double u : {0.0, 0.4, 1.7, 3.1, 5.9, 2 * pi})
    for (const double side : {-1.0, 1.0}) {
      const double pole = side * pi / 2;
      CHECK((sphere.at(u, pole) - Vec3(0, 0, side * 5)).norm() < 1e-13);
      CHECK(sphere.derivatives(u, pole).normal().isZero());
      CHECK((normal_at(sphere, u, pole) - side * Vec3::UnitZ()).norm() < 1e-9);
      const double near = side * (pi / 2 - 1e-6);
      CHECK((normal_at(sphere, u, near) - sphere.at(u, near) / 5).norm() < 1e-8);
    }
  // At the tip of a cone the limit is that of the line that leads there.
  const auto cone = exact_cone(3, 0, 4);
  for (const double u : {0.0, 1.0, 4.0}) {
    CHECK((cone.at(u, cone.v.high()) - Vec3(0, 0, 4)).norm() < 1e-13);
    CHECK((normal_at(cone, u, cone.v.high()) - normal_at(cone, u, 1.0)).norm() < 1e-9);
  }
  // A bent triangle, as a square with one edge in a point, for all four edges: compare with normals nearby.
  for (int edge = 0; edge < 4; ++edge) {
    auto s = wavy(true);
    const int rows = s.u.count(), columns = s.v.count();
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < columns; ++j)
        if ((edge == 0 && i == 0) || (edge == 1 && i == rows - 1) || (edge == 2 && j == 0) ||
            (edge == 3 && j == columns - 1))
          s.points[std::size_t(i * columns + j)] = Vec3(12, 9, 3);
    for (const double share : {0.1, 0.5, 0.8}) {
      const double u = edge == 0 ? 0 : edge == 1 ? 1 : share, v = edge == 2 ? -1 : edge == 3 ? 2 : 3 * share - 1;
      const double inner_u = edge == 0 ? 1e-6 : edge == 1 ? 1 - 1e-6 : u;
      const double inner_v = edge == 2 ? -1 + 1e-6 : edge == 3 ? 2 - 1e-6 : v;
      CHECK((s.at(u, v) - Vec3(12, 9, 3)).norm() < 1e-12);
      CHECK(s.derivatives(u, v).normal().isZero());
      CHECK(normal_at(s, u, v).norm() == Approx(1));
      CHECK((normal_at(s, u, v) - s.derivatives(inner_u, inner_v).normal()).norm() < 1e-4);
    }
  }
}

}  // namespace partscribe::geometry
