#include "geometry/surfaces/nurbs_intersect.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/number.h"
#include "geometry/surfaces/nurbs_edit.h"
#include "geometry/surfaces/nurbs_exact.h"

namespace partscribe::geometry {
namespace {

/// A square plate in z = 0, centred, in its own frame.
NurbsSurface plate(double side, const Pose& pose = {}) {
  const double h = side / 2;
  const NurbsSurface flat{
      clamped(1, {0, 1}), clamped(1, {0, 1}), {Vec3(-h, -h, 0), Vec3(-h, h, 0), Vec3(h, -h, 0), Vec3(h, h, 0)}, {}};
  return posed(flat, pose);
}

Pose at(const Vec3& place, const Vec3& turn = Vec3::Zero()) { return {rotation_of(turn), place}; }

double length_of(const IntersectionCurve& c) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < c.places.size(); ++i) sum += (c.places[i + 1].point - c.places[i].point).norm();
  return sum;
}

/// What holds of every intersection: places on both, chords near both, ends of closed curves where they begin.
void check_lies_on_both(const SplineIntersection& r, const NurbsSurface& a, const NurbsSurface& b, double tolerance) {
  CHECK(r.complete);
  for (const auto& c : r.curves) {
    REQUIRE(c.places.size() > 1);
    if (c.closed) CHECK((c.places.front().point - c.places.back().point).norm() <= tolerance);
    for (const auto& p : c.places) {
      CHECK((a.at(p.on_a.x(), p.on_a.y()) - p.point).norm() < 1e-8);
      CHECK((b.at(p.on_b.x(), p.on_b.y()) - p.point).norm() < 1e-8);
      CHECK(p.on_a.x() >= a.u.low());
      CHECK(p.on_a.x() <= a.u.high());
      CHECK(p.on_b.y() >= b.v.low());
      CHECK(p.on_b.y() <= b.v.high());
    }
  }
}

/// The largest distance of chords' middles by an equation of what the curve lies on.
template <class Distance>
double chords_off(const SplineIntersection& r, const Distance& distance) {
  double most = 0;
  for (const auto& c : r.curves)
    for (std::size_t i = 0; i + 1 < c.places.size(); ++i)
      most = std::max(most, std::abs(distance(Vec3(0.5 * (c.places[i].point + c.places[i + 1].point)))));
  return most;
}

}  // namespace

TEST_CASE("nurbs_intersect: two spheres meet in a circle of the exact radius") {
  const double d = 6, ra = 5, rb = 4;
  const Vec3 way = Vec3(1, 2, -2).normalized();
  const auto a = exact_sphere(ra), b = posed(exact_sphere(rb), at(d * way, Vec3(0.4, 0.2, -0.7)));
  const double off = (d * d + ra * ra - rb * rb) / (2 * d), radius = std::sqrt(ra * ra - off * off);
  for (const double tolerance : {1e-1, 1e-2, 1e-3}) {
    const auto r = intersection_of(a, b, tolerance);
    check_lies_on_both(r, a, b, tolerance);
    REQUIRE(r.curves.size() == 1);
    CHECK(r.curves[0].closed);
    CHECK(r.places.empty());
    CHECK(length_of(r.curves[0]) == Approx(2 * pi * radius).epsilon(2 * tolerance));
    for (const auto& p : r.curves[0].places) {
      CHECK(p.point.dot(way) == Approx(off).epsilon(1e-9));
      CHECK((p.point - off * way).norm() == Approx(radius).epsilon(1e-9));
    }
    CHECK(chords_off(r, [&](const Vec3& p) { return (p - off * way).norm() - radius; }) <= tolerance);
  }
}

TEST_CASE("nurbs_intersect: a thin cylinder passes a thick one in two closed curves on both") {
  const auto thick = exact_cylinder(5, 20);
  const auto thin = posed(exact_cylinder(3, 20), at(Vec3(-10, 0.5, 9), Vec3(0, pi / 2, 0)));
  const auto r = intersection_of(thick, thin, 1e-2);
  check_lies_on_both(r, thick, thin, 1e-2);
  REQUIRE(r.curves.size() == 2);
  for (const auto& c : r.curves) {
    CHECK(c.closed);
    for (const auto& p : c.places) {
      CHECK(std::hypot(p.point.x(), p.point.y()) == Approx(5).epsilon(1e-9));
      CHECK(std::hypot(p.point.y() - 0.5, p.point.z() - 9) == Approx(3).epsilon(1e-9));
      CHECK(p.point.x() * c.places.front().point.x() > 0);  // one on either side
    }
    CHECK(length_of(c) > 2 * pi * 3);
  }
}

TEST_CASE("nurbs_intersect: planes cut a torus in the curves that its equation says") {
  const auto torus = exact_torus(10, 3);
  struct Case {
    Pose pose;
    std::size_t loops;
  };
  for (const auto& [pose, loops] : {Case{at(Vec3(0, 0, 1)), 2},                          // parallel to its knots
                                    Case{at(Vec3(0, 0, 0)), 2},                          // along its knots
                                    Case{at(Vec3(0, 0, 0), Vec3(0.2, 0.1, 0)), 2},       // oblique
                                    Case{at(Vec3(11, 0, 0), Vec3(0, pi / 2, 0.0)), 1},   // an oval
                                    Case{at(Vec3(6.9, 0, 0), Vec3(0, pi / 2, 0.0)), 2},  // two ovals, nearly one
                                    Case{at(Vec3(0, 0, 0), Vec3(0, pi / 2, 0)), 2},      // through axis and seam
                                    Case{at(Vec3(0, 0, 2.999)), 2}}) {                   // just below the top
    const auto plane = plate(40, pose);
    const auto r = intersection_of(torus, plane, 1e-2);
    check_lies_on_both(r, torus, plane, 1e-2);
    CHECK(r.curves.size() == loops);
    for (const auto& c : r.curves) CHECK(c.closed);
    const Vec3 n = pose.rotation.col(2);
    for (const auto& c : r.curves)
      for (const auto& p : c.places) {
        CHECK(std::hypot(std::hypot(p.point.x(), p.point.y()) - 10, p.point.z()) == Approx(3).epsilon(1e-9));
        CHECK(n.dot(p.point - pose.translation) == Approx(0).margin(1e-8));
      }
  }
}

TEST_CASE("nurbs_intersect: a plane through the poles of a sphere gives one closed great circle") {
  const auto sphere = exact_sphere(5);
  for (const double turn : {0.0, 0.3, pi / 2}) {
    const auto plane = plate(20, at(Vec3::Zero(), turn * Vec3::UnitZ()) * at(Vec3::Zero(), Vec3(pi / 2, 0, 0)));
    const auto r = intersection_of(sphere, plane, 1e-2);
    check_lies_on_both(r, sphere, plane, 1e-2);
    REQUIRE(r.curves.size() == 1);
    CHECK(r.curves[0].closed);
    CHECK(length_of(r.curves[0]) == Approx(10 * pi).epsilon(1e-2));
  }
}

TEST_CASE("nurbs_intersect: a curve that leaves a surface ends on its border") {
  const auto sphere = exact_sphere(5);
  // The plate's corner stands within the sphere, so that a quarter of a circle is left.
  const auto plane = plate(10, at(Vec3(5, 5, 3)));
  const auto r = intersection_of(sphere, plane, 1e-3);
  check_lies_on_both(r, sphere, plane, 1e-3);
  REQUIRE(r.curves.size() == 1);
  const auto& c = r.curves[0];
  CHECK_FALSE(c.closed);
  CHECK(length_of(c) == Approx(2 * pi).epsilon(1e-3));
  for (const auto* end : {&c.places.front(), &c.places.back()}) {
    CHECK(std::min(std::abs(end->point.x()), std::abs(end->point.y())) < 1e-9);
    CHECK(end->on_b.minCoeff() == Approx(0).margin(1e-12));
  }
}

TEST_CASE("nurbs_intersect: what does not meet has no intersection, and what touches has a place") {
  const auto sphere = exact_sphere(5), torus = exact_torus(10, 3);
  const auto none = [](const NurbsSurface& a, const NurbsSurface& b) {
    const auto r = intersection_of(a, b, 1e-3);
    return r.complete && r.curves.empty() && r.places.empty();
  };
  CHECK(none(sphere, posed(exact_sphere(4), at(Vec3(9.001, 0, 0)))));
  CHECK(none(sphere, exact_sphere(4.9)));
  CHECK(none(sphere, posed(exact_sphere(4), at(Vec3(0.7, 0.6, 0.3)))));
  CHECK(none(sphere, plate(20, at(Vec3(0, 0, 5.0005)))));
  CHECK(none(torus, plate(100, at(Vec3(0, 0, -3.01)))));
  CHECK(none(torus, posed(exact_cylinder(6.99, 8), at(Vec3(0, 0, -4)))));
  CHECK(none(plate(10), plate(10, at(Vec3(0, 0, 0.001)))));
  CHECK(none(plate(10), plate(10, at(Vec3(10.01, 0, 0), Vec3(0, 0.5, 0)))));
  const auto touch = intersection_of(sphere, plate(20, at(Vec3(0.3, 0.2, -5))), 1e-3);
  CHECK(touch.complete);
  CHECK(touch.curves.empty());
  REQUIRE(touch.places.size() == 1);
  CHECK((touch.places[0].point - Vec3(0, 0, -5)).norm() < 1e-2);
}

TEST_CASE("nurbs_intersect: a small loop far from the places at which pieces begin is found") {
  // A plane 2e-5 below the top of a bulge: the loop is 0.03 mm wide, the surface 40.
  const auto cap = posed(exact_sphere(5), at(Vec3::Zero(), Vec3(0.9, 0.4, 0.2)));
  const auto plane = plate(40, at(Vec3(3, 1, 5 - 2e-5)));
  const auto r = intersection_of(cap, plane, 1e-3);
  check_lies_on_both(r, cap, plane, 1e-3);
  REQUIRE(r.curves.size() == 1);
  CHECK(r.curves[0].closed);
  const double radius = std::sqrt(25 - (5 - 2e-5) * (5 - 2e-5));
  for (const auto& p : r.curves[0].places) CHECK(std::hypot(p.point.x(), p.point.y()) == Approx(radius).epsilon(1e-4));
}

TEST_CASE("nurbs_intersect: free forms of degrees 1 to 5 are cut by a plane wherever their height changes sign") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> height(-4, 4), weight(0.5, 2);
  for (const bool rational : {false, true})
    for (int degree = 1; degree <= 5; ++degree) {
      NurbsSurface s{clamped(degree, {0, 1, 2, 3, 4}), clamped(degree, {0, 1, 2, 3, 4}), {}, {}};
      for (int i = 0; i < s.u.count(); ++i)
        for (int j = 0; j < s.v.count(); ++j) {
          s.points.emplace_back(3 * i, 3 * j, height(random));
          if (rational) s.weights.push_back(weight(random));
        }
      const double z = 0.1;
      const auto plane = plate(200, at(Vec3(0, 0, z)));
      const auto r = intersection_of(s, plane, 1e-2);
      check_lies_on_both(r, s, plane, 1e-2);
      // Along lines of the parameters the sign changes as often as curves pass, and where they do.
      for (int k = 0; k < 23; ++k) {
        const double u = 0.0871 + 0.171 * k;
        std::vector<double> zeros, passed;
        for (int i = 0; i < 4000; ++i) {
          const double v = i / 1000.0, low = s.at(u, v).z() - z, high = s.at(u, v + 0.001).z() - z;
          if (low * high < 0) zeros.push_back(v + 0.001 * low / (low - high));
        }
        for (const auto& c : r.curves)
          for (std::size_t i = 0; i + 1 < c.places.size(); ++i) {
            const Vec2 &a = c.places[i].on_a, &b = c.places[i + 1].on_a;
            if ((a.x() < u) != (b.x() < u)) passed.push_back(a.y() + (u - a.x()) / (b.x() - a.x()) * (b.y() - a.y()));
          }
        std::sort(passed.begin(), passed.end());
        REQUIRE(passed.size() == zeros.size());
        for (std::size_t i = 0; i < zeros.size(); ++i) CHECK(passed[i] == Approx(zeros[i]).margin(0.03));
      }
      for (const auto& c : r.curves)
        if (!c.closed)
          for (const auto* end : {&c.places.front(), &c.places.back()})
            CHECK(std::min({end->on_a.x(), end->on_a.y(), 4 - end->on_a.x(), 4 - end->on_a.y()}) < 1e-9);
    }
}

TEST_CASE("nurbs_intersect: two free forms meet along curves that pass every curve of equal u where it pierces") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> off(-1, 1), weight(0.5, 2);
    const auto made = [&](int degree, bool rational) {
      NurbsSurface s{clamped(degree, {0, 1, 2, 3}), clamped(degree, {0, 1, 2, 3}), {}, {}};
      for (int i = 0; i < s.u.count(); ++i)
        for (int j = 0; j < s.v.count(); ++j) {
          const double x = off(random), y = off(random), z = off(random);
          s.points.emplace_back(3 * (i - s.u.count() / 2) + x, 3 * (j - s.v.count() / 2) + y, 5 * z);
          if (rational) s.weights.push_back(weight(random));
        }
      return s;
    };
    const auto a = made(int(1 + seed % 5), seed % 2), other = made(int(1 + seed / 5), seed % 3 == 0);
    const double x = off(random), y = off(random), z = off(random);
    const auto b = posed(other, at(Vec3(y, z, x), Vec3(0.3 * x, 0.3 * y, z)));
    const auto r = intersection_of(a, b, 1e-2);
    check_lies_on_both(r, a, b, 1e-2);
    for (int k = 0; k < 9; ++k) {
      const double u = 0.0871 + 0.331 * k;
      int passed = 0;
      for (const auto& c : r.curves)
        for (std::size_t i = 0; i + 1 < c.places.size(); ++i)
          passed += (c.places[i].on_a.x() < u) != (c.places[i + 1].on_a.x() < u);
      CHECK(passed == int(intersection_of(iso_curve(a, false, u), b, 1e-4).places.size()));
    }
    for (const auto& c : r.curves)
      if (!c.closed)
        for (const auto* end : {&c.places.front(), &c.places.back()}) {
          const double inside_a = std::min(end->on_a.minCoeff(), 3 - end->on_a.maxCoeff());
          CHECK(std::min({inside_a, end->on_b.minCoeff(), 3 - end->on_b.maxCoeff()}) < 1e-9);
        }
  }
}

TEST_CASE("nurbs_intersect: cylinders of one radius cross in two ellipses, which pass the places where they touch") {
  const auto a = posed(exact_cylinder(4, 20), at(Vec3(0, 0, -10)));
  const auto b = posed(exact_cylinder(4, 20), at(Vec3(-10, 0, 0), Vec3(0, pi / 2, 0)));
  const auto r = intersection_of(a, b, 1e-2);
  check_lies_on_both(r, a, b, 1e-2);
  double length = 0;
  for (const auto& c : r.curves) {
    length += length_of(c);
    for (const auto& p : c.places) CHECK(std::abs(p.point.x()) == Approx(std::abs(p.point.z())).margin(1e-6));
  }
  double ellipse = 0;  // of the half axes 4 and 4 sqrt(2)
  for (int i = 0; i < 10000; ++i) {
    const double t = (i + 0.5) * pi / 5000;
    ellipse += pi / 5000 * 4 * std::hypot(std::sqrt(2.0) * std::sin(t), std::cos(t));
  }
  CHECK(length == Approx(2 * ellipse).epsilon(0.01));
}

TEST_CASE("nurbs_intersect: a line pierces a sphere where its equation says, and passes by where it does") {
  const auto sphere = posed(exact_sphere(5), at(Vec3(1, 2, 3)));
  const auto line = [](const Vec3& from, const Vec3& to) { return NurbsCurve<3>{clamped(1, {0, 1}), {from, to}, {}}; };
  const auto r = intersection_of(line(Vec3(-9, 5, 3), Vec3(11, 5, 3)), sphere, 1e-3);
  CHECK(r.complete);
  REQUIRE(r.places.size() == 2);
  CHECK((r.places[0].point - Vec3(-3, 5, 3)).norm() < 1e-9);
  CHECK((r.places[1].point - Vec3(5, 5, 3)).norm() < 1e-9);
  CHECK(r.places[1].on_a.x() == Approx(0.7));
  CHECK(intersection_of(line(Vec3(-9, 7.01, 3), Vec3(11, 7.01, 3)), sphere, 1e-3).places.empty());
  CHECK(intersection_of(line(Vec3(0, 2, 3), Vec3(3, 2, 3)), sphere, 1e-3).places.empty());
  CHECK(intersection_of(line(Vec3(0, 2, 3), Vec3(9, 2, 3)), sphere, 1e-3).places.size() == 1);
}

TEST_CASE("nurbs_intersect: curves in a plane cross where circles do, and curves in space hardly ever") {
  const auto circle = [](const Vec2& center, double radius) {
    return in_space(exact_arc({center, radius, 0.3, 0.3 + 2 * pi}));
  };
  const auto r = intersection_of(circle(Vec2(0, 0), 5), circle(Vec2(6, 0), 5), 1e-3);
  REQUIRE(r.places.size() == 2);
  for (const auto& p : r.places) {
    CHECK(p.point.x() == Approx(3).epsilon(1e-9));
    CHECK(std::abs(p.point.y()) == Approx(4).epsilon(1e-9));
  }
  CHECK(intersection_of(circle(Vec2(0, 0), 5), circle(Vec2(10.01, 0), 5), 1e-3).places.empty());
  CHECK(
      intersection_of(circle(Vec2(0, 0), 5), posed(circle(Vec2(6, 0), 5), at(Vec3(0, 0, 0.01))), 1e-3).places.empty());
  // A wave of degree 7 and its chord.
  NurbsCurve<3> wave{clamped(7, {0, 1, 2}), {}, {}};
  for (int i = 0; i < wave.t.count(); ++i) wave.points.emplace_back(i, i % 2 ? 40 : -40, 0);
  const NurbsCurve<3> chord{clamped(1, {0, 1}), {Vec3(-1, 0.5, 0), Vec3(9, 0.25, 0)}, {}};
  int signs = 0;
  const auto above = [&](double t) { return wave.at(t).y() - 0.475 + 0.025 * wave.at(t).x() > 0; };
  for (int i = 0; i < 20000; ++i) signs += above(i / 10000.0) != above((i + 1) / 10000.0);
  const auto crossed = intersection_of(wave, chord, 1e-4);
  CHECK(int(crossed.places.size()) == signs);
  CHECK(signs >= 3);
}

TEST_CASE("nurbs_intersect: surfaces that lie upon one another are given up, and say so") {
  const auto s = exact_sphere(5);
  CHECK_FALSE(intersection_of(s, posed(s, at(Vec3::Zero(), Vec3(0, 0, 0.3))), 1e-4).complete);
}

}  // namespace partscribe::geometry
