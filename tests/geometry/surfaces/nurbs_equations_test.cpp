/// Claims about B-splines as the paper of 1993 states them, against its equations written down once more.
#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "geometry/surfaces/nurbs.h"

namespace partscribe::geometry {
namespace {

const KnotVector many_knots{3, {0, 0, 0, 0, 0.2, 0.5, 0.5, 0.7, 0.7, 0.7, 1, 1, 1, 1}};

/// N_i,k(u) of order k by equations (2) and (3); 0 / 0 counts as 0, and `zeros` how often that was needed. Intervals
/// are half open, the last one that is not empty is closed; or all of them closed, as the paper prints them.
double by_recursion(const std::vector<double>& x, std::size_t i, std::size_t k, double u, bool all_closed,
                    std::size_t& zeros) {
  if (k == 1) {
    const bool closed = all_closed || x[i + 1] == x.back();
    return x[i] < x[i + 1] && x[i] <= u && (closed ? u <= x[i + 1] : u < x[i + 1]) ? 1 : 0;
  }
  const auto share = [&](double above, double below, double less) {
    if (below == 0) ++zeros;
    return below == 0 ? 0 : above / below * less;
  };
  return share(u - x[i], x[i + k - 1] - x[i], by_recursion(x, i, k - 1, u, all_closed, zeros)) +
         share(x[i + k] - u, x[i + k] - x[i + 1], by_recursion(x, i + 1, k - 1, u, all_closed, zeros));
}

double by_recursion(const KnotVector& knots, int i, double u) {
  std::size_t zeros = 0;
  return by_recursion(knots.knots, std::size_t(i), std::size_t(knots.degree) + 1, u, false, zeros);
}

/// The domain's knots and places between them.
std::vector<double> places_in(const KnotVector& knots) {
  std::vector<double> places = knots.breaks();
  for (int i = 0; i <= 60; ++i) places.push_back(knots.low() + (knots.high() - knots.low()) * i / 60);
  return places;
}

NurbsSurface hilly(bool rational) {
  NurbsSurface s{many_knots, clamped(2, {-1, 0, 0, 2}), {}, {}};
  Random random(11);
  for (int i = 0; i < s.u.count(); ++i)
    for (int j = 0; j < s.v.count(); ++j) {
      s.points.emplace_back(10 * i, 8 * j, random.uniform(-6, 6));
      if (rational) s.weights.push_back(random.uniform(0.3, 2));
    }
  return s;
}

/// Half a turn of a profile as rational quadratic arcs about z, in two quarters; rows of the net run along the profile.
NurbsSurface half_turn(const KnotVector& along, const std::vector<Vec2>& profile, const std::vector<double>& weights) {
  NurbsSurface s{along, {2, {0, 0, 0, 1, 1, 2, 2, 2}}, {}, {}};
  for (std::size_t i = 0; i < profile.size(); ++i)
    for (int k = 0; k <= 4; ++k) {
      const double angle = k * pi / 4, reach = profile[i].x() * (k % 2 ? std::sqrt(2.0) : 1);
      s.points.emplace_back(reach * std::cos(angle), reach * std::sin(angle), profile[i].y());
      s.weights.push_back(weights[i] * (k % 2 ? std::sqrt(0.5) : 1));
    }
  return s;
}

}  // namespace

TEST_CASE("nurbs: basis functions are those of the recursion with half-open intervals and 0 / 0 as 0") {
  std::size_t zeros = 0;
  for (const KnotVector& knots :
       {many_knots, clamped(1, {0, 0.3, 1}), clamped(2, {0, 0.3, 0.3, 2}), clamped(3, {-1, 0, 0, 0, 0, 1})}) {
    for (const double t : places_in(knots)) {
      BasisValues n;
      basis(knots, t, 0, n);
      for (int i = 0; i < knots.count(); ++i) {
        const bool lives = i >= n.first && i <= n.first + knots.degree;
        const double expected =
            by_recursion(knots.knots, std::size_t(i), std::size_t(knots.degree) + 1, t, false, zeros);
        INFO("degree " << knots.degree << ", function " << i << " at " << t);
        CHECK((lives ? n.value[0][i - n.first] : 0) == Approx(expected).margin(1e-14));
      }
    }
  }
  CHECK(zeros > 1000);  // knots that coincide are met
}

TEST_CASE("nurbs: intervals closed at both ends, as equation (2) is printed, would count a knot twice") {
  const auto sum = [](double t, bool all_closed) {
    double result = 0;
    std::size_t zeros = 0;
    for (int i = 0; i < many_knots.count(); ++i)
      result += by_recursion(many_knots.knots, std::size_t(i), 4, t, all_closed, zeros);
    return result;
  };
  CHECK(sum(0.2, true) == Approx(2));
  CHECK(sum(0.3, true) == Approx(1));
  for (const double t : places_in(many_knots)) CHECK(sum(t, false) == Approx(1));
}

TEST_CASE("nurbs: a surface is the quotient of the two sums over its control points") {
  for (const bool rational : {false, true}) {
    const NurbsSurface s = hilly(rational);
    for (const double u : places_in(s.u))
      for (const double v : {-1.0, -0.6, 0.0, 0.9, 2.0}) {
        Vec3 above = Vec3::Zero();
        double below = 0;
        for (int i = 0; i < s.u.count(); ++i)
          for (int j = 0; j < s.v.count(); ++j) {
            const std::size_t c = std::size_t(i * s.v.count() + j);
            const double share = (rational ? s.weights[c] : 1) * by_recursion(s.u, i, u) * by_recursion(s.v, j, v);
            above += share * s.points[c], below += share;
          }
        CHECK((s.at(u, v) - above / below).norm() < 1e-11);
      }
  }
}

TEST_CASE("nurbs: a surface begins and ends in the corners of its net, and its borders are those of the net") {
  const NurbsSurface s = hilly(true);
  const int rows = s.u.count(), columns = s.v.count();
  const auto control = [&](int i, int j) { return s.points[std::size_t(i * columns + j)]; };
  CHECK((s.at(0, -1) - control(0, 0)).norm() < 1e-13);
  CHECK((s.at(0, 2) - control(0, columns - 1)).norm() < 1e-13);
  CHECK((s.at(1, -1) - control(rows - 1, 0)).norm() < 1e-13);
  CHECK((s.at(1, 2) - control(rows - 1, columns - 1)).norm() < 1e-13);
  NurbsCurve<3> last{s.v, {}, {}};
  for (int j = 0; j < columns; ++j)
    last.points.push_back(control(rows - 1, j)),
        last.weights.push_back(s.weights[std::size_t((rows - 1) * columns + j)]);
  for (const double v : places_in(s.v)) CHECK((s.at(1, v) - last.at(v)).norm() < 1e-13);
}

TEST_CASE("nurbs: a surface stays in the hull of its net, and a control point moves only what is near") {
  const NurbsSurface s = hilly(true);
  const int columns = s.v.count();
  Random random(3);
  std::vector<Vec3> directions;
  for (int k = 0; k < 60; ++k)
    directions.push_back(Vec3(random.normal(), random.normal(), random.normal()).normalized());
  NurbsSurface other = s;
  const int i = 4, j = 2;
  other.points[std::size_t(i * columns + j)] += Vec3(1, 2, 3);
  std::size_t moved = 0, kept = 0;
  for (int a = 0; a <= 100; ++a)
    for (int b = 0; b <= 30; ++b) {
      const double u = a / 100.0, v = -1 + b / 10.0;
      const Vec3 p = s.at(u, v);
      for (const Vec3& d : directions) {
        double most = -1e300;
        for (const Vec3& c : s.points) most = std::max(most, c.dot(d));
        REQUIRE(p.dot(d) <= most + 1e-11);
      }
      const auto within = [](const KnotVector& k, int c, double t) {
        return t > k.knots[std::size_t(c)] && t < k.knots[std::size_t(c + k.degree + 1)];
      };
      const bool lives = within(s.u, i, u) && within(s.v, j, v);
      REQUIRE(((other.at(u, v) - p).norm() > 1e-12) == lives);
      (lives ? moved : kept) += 1;
    }
  CHECK(moved > 100);
  CHECK(kept > 1000);
}

TEST_CASE("nurbs: a knot takes as many derivatives as it is multiple, and as many as the order let a cubic jump") {
  Random random(5);
  for (int multiple = 1; multiple <= 4; ++multiple) {
    std::vector<double> breaks = {0, 0.2};
    breaks.insert(breaks.end(), std::size_t(multiple), 0.5);
    breaks.insert(breaks.end(), {0.8, 1});
    NurbsCurve<2> curve{clamped(3, breaks), {}, {}};
    for (int i = 0; i < curve.t.count(); ++i) curve.points.emplace_back(random.uniform(-5, 5), random.uniform(-5, 5));
    Vec2 before[3], after[3];
    curve.derivatives(std::nextafter(0.5, 0), before[0], before[1], before[2]);
    curve.derivatives(0.5, after[0], after[1], after[2]);
    for (int d = 0; d < 3; ++d) {
      INFO("knots " << multiple << ", derivative " << d);
      CHECK(((before[d] - after[d]).norm() < 1e-9) == (d <= 3 - multiple));
    }
  }
  // So does a surface, along a whole line.
  NurbsSurface s{clamped(3, {0, 0.5, 0.5, 0.5, 0.5, 1}), clamped(3, {0, 1}), {}, {}};
  for (int i = 0; i < s.u.count(); ++i)
    for (int j = 0; j < 4; ++j) s.points.emplace_back(i, j, i < 4 ? 0 : 7);  // a step
  for (int j = 0; j <= 10; ++j) {
    CHECK(s.at(std::nextafter(0.5, 0), j / 10.0).z() == Approx(0).margin(1e-12));
    CHECK(s.at(0.5, j / 10.0).z() == Approx(7));
  }
}

TEST_CASE("nurbs: four knots inserted at one place part a cubic into two that share no control point") {
  NurbsCurve<3> whole{clamped(3, {0, 0.4, 1}), {{0, 0, 0}, {1, 4, 0}, {3, -2, 1}, {5, 3, 2}, {7, 0, 0}}, {}};
  NurbsCurve<3> parted = with_knot(whole, 0.6, 4);
  CHECK(parted.points.size() == whole.points.size() + 4);
  for (int i = 0; i <= 100; ++i) CHECK((parted.at(i / 100.0) - whole.at(i / 100.0)).norm() < 1e-12);
  // Of knots 0 0 0 0 0.4 | 0.6 0.6 0.6 0.6 | 1 1 1 1 the first five control points belong to the left.
  for (std::size_t i = 5; i < parted.points.size(); ++i) parted.points[i] += Vec3(0, 0, 9);
  for (int i = 0; i <= 100; ++i) {
    const double t = i / 100.0;
    const Vec3 lift(0, 0, t < 0.6 ? 0 : 9);
    CHECK((parted.at(t) - whole.at(t) - lift).norm() < 1e-12);
  }
}

TEST_CASE("nurbs: cylinder, cone, ball and torus are rational surfaces without any error") {
  const double h = std::sqrt(0.5);
  const NurbsSurface cylinder = half_turn(clamped(1, {0, 1}), {{7, -2}, {7, 9}}, {1, 1});
  const NurbsSurface cone = half_turn(clamped(1, {0, 1}), {{0, 0}, {6, 8}}, {1, 1});
  const NurbsSurface ball =
      half_turn({2, {0, 0, 0, 1, 1, 2, 2, 2}}, {{0, -5}, {5, -5}, {5, 0}, {5, 5}, {0, 5}}, {1, h, 1, h, 1});
  const NurbsSurface torus =
      half_turn({2, {0, 0, 0, 1, 1, 2, 2, 2}}, {{20, -5}, {25, -5}, {25, 0}, {25, 5}, {20, 5}}, {1, h, 1, h, 1});
  for (int i = 0; i <= 20; ++i)
    for (int j = 0; j <= 20; ++j) {
      const double v = j / 10.0;
      const auto radius = [](const Vec3& p) { return std::hypot(p.x(), p.y()); };
      CHECK(radius(cylinder.at(i / 20.0, v)) == Approx(7).margin(1e-13));
      const Vec3 c = cone.at(i / 20.0, v), t = torus.at(i / 10.0, v);
      CHECK(radius(c) == Approx(0.75 * c.z()).margin(1e-13));
      CHECK(ball.at(i / 10.0, v).norm() == Approx(5).margin(1e-13));
      CHECK(std::hypot(radius(t) - 20, t.z()) == Approx(5).margin(1e-13));
    }
}

TEST_CASE(
    "nurbs: an edge of the net drawn together into one point is a point of the surface, and feet are found by it") {
  const NurbsSurface cone = half_turn(clamped(1, {0, 1}), {{0, 3}, {6, 11}}, {1, 1});
  const Vec3 tip(0, 0, 3);
  for (int j = 0; j <= 20; ++j) {
    const auto at = cone.derivatives(0, j / 10.0);
    CHECK((at.p - tip).norm() < 1e-14);
    CHECK(at.dv.norm() < 1e-13);
    CHECK(at.du.norm() > 5);
    CHECK(at.normal().isZero());  // there is none in a tip
  }
  // Beside the tip there is: a point lifted off along it comes back.
  for (const double u : {0.02, 0.3, 0.9})
    for (const double v : {0.3, 1.0, 1.7}) {
      const auto at = cone.derivatives(u, v);
      const auto foot = foot_near(cone, at.p - 0.01 * at.normal(), u + 0.01, v + 0.05);
      CHECK(foot.distance == Approx(0.01).epsilon(1e-6));
      CHECK((foot.point - at.p).norm() < 1e-5);
    }
  const auto below = foot_near(cone, tip - Vec3(0, 0, 2), 0.1, 1.0);
  CHECK(below.distance == Approx(2).epsilon(1e-9));
  CHECK((below.point - tip).norm() < 1e-9);
}

}  // namespace partscribe::geometry
