#include "geometry/surfaces/nurbs_edit.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/number.h"

namespace partscribe::geometry {
namespace {

/// Over 0 .. 4, with inner knots of every multiplicity up to that of a gap.
KnotVector rough_knots(int degree, int most) {
  KnotVector t = clamped(degree, {0, 4});
  int times = 1;
  for (const double knot : {0.75, 1.5, 1.625, 2.0, 3.5}) {
    for (int i = 0; i < std::min(times, most); ++i) t = with_knot(t, knot);
    ++times;
  }
  return t;
}

/// Control points at random, nothing of which is symmetric.
template <int D>
NurbsCurve<D> rough_curve(const KnotVector& t, bool rational, unsigned seed) {
  NurbsCurve<D> c{t, {}, {}};
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-10, 10), weight(0.4, 2.5);
  for (int i = 0; i < t.count(); ++i) {
    typename NurbsCurve<D>::Point p;
    for (int k = 0; k < D; ++k) p[k] = coordinate(random);
    c.points.push_back(p);
    if (rational) c.weights.push_back(weight(random));
  }
  return c;
}

NurbsSurface rough_surface(const KnotVector& u, const KnotVector& v, bool rational, unsigned seed) {
  NurbsSurface s{u, v, {}, {}};
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> off(-3, 3), weight(0.4, 2.5);
  for (int i = 0; i < u.count(); ++i)
    for (int j = 0; j < v.count(); ++j) {
      const double x = off(random), y = off(random), z = off(random);
      s.points.emplace_back(8 * i + x, 6 * j + y, z);
      if (rational) s.weights.push_back(weight(random));
    }
  return s;
}

/// Places of a domain, its ends and all knots of it among them.
std::vector<double> places_of(const KnotVector& t) {
  std::vector<double> places = t.breaks();
  for (int i = 0; i <= 64; ++i) places.push_back(t.low() + (t.high() - t.low()) * i / 64);
  return places;
}

/// The largest distance at equal parameters of the second.
template <int D>
double curves_apart(const NurbsCurve<D>& a, const NurbsCurve<D>& b) {
  double most = 0;
  for (const double t : places_of(b.t)) most = std::max(most, (a.at(t) - b.at(t)).norm());
  return most;
}

double surfaces_apart(const NurbsSurface& a, const NurbsSurface& b) {
  double most = 0;
  for (const double u : places_of(b.u))
    for (const double v : places_of(b.v)) most = std::max(most, (a.at(u, v) - b.at(u, v)).norm());
  return most;
}

/// The circle of radius 5 as four rational quadratic arcs.
NurbsCurve<3> four_arcs() {
  NurbsCurve<3> c{{2, {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4}}, {}, {}};
  for (int k = 0; k <= 8; ++k) {
    const double angle = k * pi / 4, radius = k % 2 ? 5 * std::sqrt(2.0) : 5;
    c.points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 1);
    c.weights.push_back(k % 2 ? std::sqrt(0.5) : 1);
  }
  return c;
}

constexpr double same = 1e-11;  // mm, 1e-12 of the control points' spread

}  // namespace

TEST_CASE("nurbs_edit: a curve of a higher degree is the same curve, gaps and creases included") {
  for (const bool rational : {false, true})
    for (int degree = 1; degree <= 7; ++degree) {
      const auto c = rough_curve<3>(rough_knots(degree, degree + 1), rational, 1);
      const auto higher = with_higher_degree(c);
      CHECK(higher.t.degree == degree + 1);
      CHECK(higher.weights.size() == (rational ? higher.points.size() : 0));
      CHECK(curves_apart(higher, c) < same);
      CHECK(curves_apart(with_higher_degree(c, 3), c) < 4 * same);
      // Every knot as often again: no place became smoother or rougher.
      const auto before = c.t.multiplicities(), after = higher.t.multiplicities();
      REQUIRE(after.size() == before.size());
      for (std::size_t i = 0; i < after.size(); ++i) CHECK(after[i].second == before[i].second + 1);
    }
}

TEST_CASE("nurbs_edit: a straight line of any degree has its control points at equal steps") {
  const NurbsCurve<3> line{clamped(1, {0, 1}), {Vec3(1, 2, 3), Vec3(7, -4, 9)}, {}};
  const auto seventh = with_higher_degree(line, 6);
  REQUIRE(seventh.points.size() == 8);
  for (int i = 0; i < 8; ++i) CHECK((seventh.points[std::size_t(i)] - line.at(i / 7.0)).norm() < 1e-14);
}

TEST_CASE("nurbs_edit: a surface of a higher degree is the same surface") {
  for (const bool rational : {false, true})
    for (const bool along_u : {false, true}) {
      const auto s = rough_surface(rough_knots(3, 3), rough_knots(2, 1), rational, 2);
      const auto higher = with_higher_degree(s, along_u, 2);
      CHECK(higher.u.degree == (along_u ? 5 : 3));
      CHECK(higher.v.degree == (along_u ? 2 : 4));
      CHECK(surfaces_apart(higher, s) < 1e-10);
    }
}

TEST_CASE("nurbs_edit: removing knots undoes their insertion") {
  for (const bool rational : {false, true})
    for (int degree = 1; degree <= 7; ++degree) {
      const auto c = rough_curve<3>(rough_knots(degree, 1), rational, 3);
      // Between knots, and at one that is there already; up to the degree, and to a gap that is none.
      for (const double t : {0.6, 2.0})
        for (int times = 1; times <= (t == 2 ? degree : degree + 1); ++times) {
          const auto undone = without_knot(with_knot(c, t, times), t, times, 1e-9);
          CHECK(undone.removed == times);
          CHECK(undone.deviation < same);
          CHECK(undone.spline.t == c.t);
          REQUIRE(undone.spline.points.size() == c.points.size());
          for (std::size_t i = 0; i < c.points.size(); ++i) {
            CHECK((undone.spline.points[i] - c.points[i]).norm() < 10 * same);
            if (rational) CHECK(undone.spline.weights[i] == Approx(c.weights[i]).epsilon(1e-11));
          }
        }
    }
  const auto s = rough_surface(rough_knots(3, 2), rough_knots(2, 1), true, 4);
  for (const bool along_u : {false, true}) {
    const auto undone = without_knot(with_knot(s, along_u, 1.25, 2), along_u, 1.25, 2, 1e-9);
    CHECK(undone.removed == 2);
    CHECK(undone.spline.u == s.u);
    CHECK(undone.spline.v == s.v);
    CHECK(surfaces_apart(undone.spline, s) < same);
  }
}

TEST_CASE("nurbs_edit: a knot that is needed stays, and none moves the curve farther than was told") {
  for (const bool rational : {false, true})
    for (int degree = 1; degree <= 5; ++degree) {
      const auto c = rough_curve<2>(rough_knots(degree, 1), rational, 5);
      CHECK(without_knot(c, 1.5, 1, 1e-6).removed == 0);
      CHECK(without_knot(c, 1.5, 1, 1e-6).spline.t == c.t);
      CHECK(curves_apart(without_knot(c, 1.5, 1, 1e-6).spline, c) < same);
      int before = 0;
      for (const double tolerance : {1e-6, 1.0, 8.0, 30.0, 100.0}) {
        const auto fewer = without_spare_knots(c, tolerance);
        CHECK(fewer.deviation <= tolerance);
        CHECK(curves_apart(fewer.spline, c) <= fewer.deviation + same);
        CHECK(int(fewer.spline.points.size()) == int(c.points.size()) - fewer.removed);
        CHECK(fewer.removed >= before);
        before = fewer.removed;
      }
      CHECK(before > 0);
    }
}

TEST_CASE("nurbs_edit: what was refined everywhere becomes what it was") {
  for (const bool rational : {false, true}) {
    auto c = rough_curve<3>(rough_knots(3, 2), rational, 6);
    auto fine = c;
    for (int i = 1; i < 40; ++i) fine = with_knot(fine, 0.1 * i + 0.003);
    const auto curve = without_spare_knots(fine, 1e-8);
    CHECK(curve.removed == 39);
    CHECK(curve.spline.t == c.t);
    CHECK(curves_apart(curve.spline, c) < 1e-8);
    const auto s = rough_surface(rough_knots(2, 1), rough_knots(3, 1), rational, 7);
    auto fine_surface = s;
    for (int i = 1; i < 8; ++i) fine_surface = with_knot(with_knot(fine_surface, true, 0.45 * i), false, 0.41 * i);
    const auto surface = without_spare_knots(fine_surface, 1e-8);
    CHECK(surface.removed == 14);
    CHECK(surface.spline.u == s.u);
    CHECK(surface.spline.v == s.v);
    CHECK(surfaces_apart(surface.spline, s) < 1e-8);
  }
}

TEST_CASE("nurbs_edit: a degree that was raised leaves knots that can all be spared but those of the higher degree") {
  // A cubic parabola in two pieces that are one: nothing but the bare polynomial remains.
  NurbsCurve<2> c{clamped(3, {0, 1}), {Vec2(0, 0), Vec2(1, 3), Vec2(2, -3), Vec2(3, 0)}, {}};
  const auto higher = with_higher_degree(with_knot(c, 0.25), 2);
  const auto bare = without_spare_knots(higher, 1e-9);
  CHECK(bare.removed == 3);
  CHECK(bare.spline.t == clamped(5, {0, 1}));
  CHECK(curves_apart(bare.spline, c) < 1e-12);
}

TEST_CASE("nurbs_edit: the two sides of a split are what was there, and meet") {
  for (const bool rational : {false, true})
    for (int degree = 1; degree <= 7; ++degree) {
      const auto c = rough_curve<3>(rough_knots(degree, degree), rational, 8);
      for (const double t : {0.3, 1.5, 1.625, 3.5, 3.9}) {
        const auto [before, after] = split_at(c, t);
        CHECK(before.t.low() == 0);
        CHECK(before.t.high() == t);
        CHECK(after.t.low() == t);
        CHECK(after.t.high() == 4);
        CHECK(curves_apart(c, before) < same);
        CHECK(curves_apart(c, after) < same);
        CHECK((before.points.back() - after.points.front()).norm() < same);
      }
      const auto part = part_between(c, 0.5, 2.0);
      CHECK(part.t.breaks() == std::vector<double>{0.5, 0.75, 1.5, 1.625, 2.0});
      CHECK(curves_apart(c, part) < same);
    }
}

TEST_CASE("nurbs_edit: at a gap each side keeps its own end") {
  auto t = with_knot(with_knot(with_knot(clamped(2, {0, 1}), 0.5), 0.5), 0.5);
  const NurbsCurve<2> c{t, {Vec2(0, 0), Vec2(1, 0), Vec2(2, 0), Vec2(2, 5), Vec2(3, 5), Vec2(4, 5)}, {}};
  const auto [before, after] = split_at(c, 0.5);
  CHECK(before.points.back() == Vec2(2, 0));
  CHECK(after.points.front() == Vec2(2, 5));
}

TEST_CASE("nurbs_edit: a surface's parts and Bezier pieces are the surface") {
  for (const bool rational : {false, true}) {
    const auto s = rough_surface(rough_knots(3, 2), rough_knots(2, 2), rational, 9);
    for (const bool along_u : {false, true}) {
      const auto [before, after] = split_at(s, along_u, 1.3);
      CHECK(surfaces_apart(s, before) < same);
      CHECK(surfaces_apart(s, after) < same);
    }
    const auto pieces = bezier_pieces(s);
    CHECK(pieces.size() == 36);
    double area = 0;
    for (const auto& piece : pieces) {
      CHECK(piece.points.size() == 12);
      CHECK(piece.u.breaks().size() == 2);
      CHECK(piece.v.breaks().size() == 2);
      CHECK(surfaces_apart(s, piece) < same);
      area += (piece.u.high() - piece.u.low()) * (piece.v.high() - piece.v.low());
    }
    CHECK(area == Approx(16));
    const auto c = rough_curve<2>(rough_knots(4, 4), rational, 10);
    for (const auto& piece : bezier_pieces(c)) {
      CHECK(piece.points.size() == 5);
      CHECK(curves_apart(c, piece) < same);
    }
  }
}

TEST_CASE("nurbs_edit: backwards is the same the other way round, and twice backwards is forwards") {
  for (const bool rational : {false, true}) {
    const auto c = rough_curve<3>(rough_knots(3, 3), rational, 11);
    for (const double t : {0.0, 0.3, 1.1, 2.9, 4.0}) CHECK((reversed(c).at(t) - c.at(4 - t)).norm() < same);
    CHECK(reversed(reversed(c)) == c);
    const auto s = rough_surface(rough_knots(3, 2), rough_knots(2, 1), rational, 12);
    for (const double u : {0.0, 0.3, 2.9, 4.0})
      for (const double v : {0.0, 1.1, 4.0}) {
        CHECK((reversed(s, true).at(u, v) - s.at(4 - u, v)).norm() < same);
        CHECK((reversed(s, false).at(u, v) - s.at(u, 4 - v)).norm() < same);
      }
    CHECK(reversed(reversed(s, true), true) == s);
    CHECK(reversed(reversed(s, false), false) == s);
  }
}

TEST_CASE("nurbs_edit: curves of equal u or v lie on the surface") {
  for (const bool rational : {false, true}) {
    const auto s = rough_surface(rough_knots(3, 2), rough_knots(2, 1), rational, 13);
    for (const double at : {0.0, 0.75, 1.2, 4.0}) {
      const auto along_u = iso_curve(s, true, at), along_v = iso_curve(s, false, at);
      CHECK(along_u.t == s.u);
      CHECK(along_v.t == s.v);
      for (const double t : places_of(s.u)) CHECK((along_u.at(t) - s.at(t, at)).norm() < same);
      for (const double t : places_of(s.v)) CHECK((along_v.at(t) - s.at(at, t)).norm() < same);
    }
  }
}

TEST_CASE("nurbs_edit: clamping a periodic curve changes nothing of it, and wrapping gives the periodic one back") {
  for (const bool rational : {false, true})
    for (int degree = 1; degree <= 7; ++degree) {
      // Uneven knots of period 4, and as many control points, of which the first ones come again.
      KnotVector t{degree, {}};
      const std::vector<double> once{0, 0.5, 0.75, 1.5, 2, 2.25, 3, 3.5};
      for (int i = -degree; i <= 8 + degree; ++i) {
        const int turns = i >= 0 ? i / 8 : -1;
        t.knots.push_back(once[std::size_t(i - 8 * turns)] + 4 * turns);
      }
      auto c = rough_curve<3>(t, rational, 14);
      for (int i = 0; i < degree; ++i) {
        c.points[std::size_t(8 + i)] = c.points[std::size_t(i)];
        if (rational) c.weights[std::size_t(8 + i)] = c.weights[std::size_t(i)];
      }
      const auto open = with_clamped_ends(c);
      CHECK(open.t.knots.front() == 0);
      CHECK(open.t.knots.back() == 4);
      CHECK((open.points.front() - open.points.back()).norm() < same);
      CHECK(curves_apart(open, c) < same);
      CHECK(with_clamped_ends(open) == open);
      const auto wrapped = with_wrapped_knots(open, 1e-8);
      REQUIRE(wrapped);
      CHECK(wrapped->t == c.t);
      for (std::size_t i = 0; i < c.points.size(); ++i) CHECK((wrapped->points[i] - c.points[i]).norm() < 1e-8);
      CHECK(curves_apart(*wrapped, c) < 1e-8);
    }
}

TEST_CASE("nurbs_edit: a closed curve keeps its crease at the seam, and an open one is not wrapped") {
  const auto circle = four_arcs();
  const auto wrapped = with_wrapped_knots(circle, 1e-9);
  REQUIRE(wrapped);
  CHECK(curves_apart(*wrapped, circle) < 1e-12);
  CHECK(wrapped->points.size() == 9);  // the seam stays double, as all other knots of this circle
  CHECK(curves_apart(with_clamped_ends(*wrapped), circle) < 1e-12);
  CHECK_FALSE(with_wrapped_knots(split_at(circle, 3.0).first, 1e-3));
  NurbsCurve<2> drop{clamped(3, {0, 1, 2}), {Vec2(0, 0), Vec2(4, 1), Vec2(2, 6), Vec2(-4, 1), Vec2(0, 0)}, {}};
  const auto creased = with_wrapped_knots(drop, 1e-9);
  REQUIRE(creased);
  CHECK(creased->points.size() == 5);
  CHECK(curves_apart(*creased, drop) < 1e-12);
}

TEST_CASE("nurbs_edit: a closed surface is wrapped along the parameter that closes it") {
  NurbsSurface tube{four_arcs().t, clamped(1, {0, 1}), {}, {}};
  const auto circle = four_arcs();
  for (std::size_t i = 0; i < circle.points.size(); ++i)
    for (const double z : {0.0, 7.0}) {
      tube.points.push_back(circle.points[i] + z * Vec3::UnitZ());
      tube.weights.push_back(circle.weights[i]);
    }
  const auto wrapped = with_wrapped_knots(tube, true, 1e-9);
  REQUIRE(wrapped);
  CHECK(surfaces_apart(*wrapped, tube) < 1e-12);
  CHECK(surfaces_apart(with_clamped_ends(*wrapped, true), tube) < 1e-12);
  CHECK_FALSE(with_wrapped_knots(tube, false, 1e-3));
}

}  // namespace partscribe::geometry
