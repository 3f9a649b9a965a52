#include "geometry/surfaces/nurbs_exact.h"

#include <algorithm>
#include <cmath>

#include "core/ensure.h"
#include "core/number.h"
#include "geometry/surfaces/nurbs_edit.h"

namespace partscribe::geometry {
namespace {

/// A conic as a chain of quadratic pieces: at the ends of a piece it has weight 1, where the tangents at these meet a
/// middle control point. For places c(t) a + s(t) b whose pieces are h long on either side of their middles m, that
/// point is (c(m) a + s(m) b) / c(h), and its weight c(h); c, s: cos, sin or cosh, sinh.
template <class Cosine, class Sine>
NurbsCurve<2> conic_pieces(const Vec2& center, const Vec2& a, const Vec2& b, double from, double to, int pieces,
                           const Cosine& c, const Sine& s) {
  ensure(from < to, "a conic's arc runs from a lower to a higher parameter");
  const double half = 0.5 * (to - from) / pieces, weight = c(half);
  NurbsCurve<2> curve{{2, {from}}, {}, {}};
  for (int i = 0; i <= 2 * pieces; ++i) {
    const double t = i == 2 * pieces ? to : from + i * half, w = i % 2 ? weight : 1;
    curve.points.push_back(center + (c(t) * a + s(t) * b) / w);
    curve.weights.push_back(w);
    if (i % 2 == 0) curve.t.knots.insert(curve.t.knots.end(), 2, t);
  }
  curve.t.knots.push_back(to);
  return curve;
}

int quarter_turns(double angle) { return std::max(1, int(std::ceil(2 * angle / pi - 1e-9))); }

NurbsCurve<2> straight_profile(const Vec2& from, const Vec2& to) {
  return {clamped(1, {0, (to - from).norm()}), {from, to}, {}};
}

template <class Spline>
Spline posed_spline(Spline spline, const Pose& to_from) {
  for (Vec3& p : spline.points) p = to_from * p;
  return spline;
}

NurbsCurve<3> over_unit(NurbsCurve<3> curve) {
  const double low = curve.t.low(), length = curve.t.high() - low;
  for (double& knot : curve.t.knots) knot = (knot - low) / length;
  return curve;
}

/// Adds the knots of the other that this one has not, or less often. Knots nearer than rounding are one.
NurbsCurve<3> with_knots_of(NurbsCurve<3> curve, const KnotVector& other) {
  for (const auto& [other_knot, times] : other.multiplicities()) {
    const double knot = other_knot;
    const auto own = curve.t.multiplicities();
    const auto near =
        std::find_if(own.begin(), own.end(), [&](const auto& k) { return std::abs(k.first - knot) < 1e-12; });
    const int there = near == own.end() ? 0 : near->second;
    if (times > there) curve = with_knot(curve, near == own.end() ? knot : near->first, times - there);
  }
  return curve;
}

}  // namespace

NurbsCurve<2> exact_ellipse(const Vec2& center, const Vec2& a, const Vec2& b, double from, double to) {
  ensure(to - from < 2 * pi + 1e-9, "an ellipse is at most a full turn");
  NurbsCurve<2> curve = conic_pieces(
      center, a, b, from, to, quarter_turns(to - from), [](double t) { return std::cos(t); },
      [](double t) { return std::sin(t); });
  // Sines of a full turn are not quite those of none.
  if (std::abs(to - from - 2 * pi) < 1e-12) curve.points.back() = curve.points.front();
  return curve;
}

NurbsCurve<2> exact_arc(const Arc2& arc) {
  const double turn = std::abs(arc.to - arc.from), side = arc.to > arc.from ? 1 : -1;
  const Vec2 a = arc.radius * Vec2(std::cos(arc.from), std::sin(arc.from)), b = side * Vec2(-a.y(), a.x());
  return exact_ellipse(arc.center, a, b, 0, turn);
}

NurbsCurve<2> exact_hyperbola(const Vec2& center, const Vec2& a, const Vec2& b, double from, double to) {
  return conic_pieces(
      center, a, b, from, to, std::max(1, int(std::ceil(to - from))), [](double t) { return std::cosh(t); },
      [](double t) { return std::sinh(t); });
}

NurbsCurve<2> exact_parabola(const Vec2& vertex, const Vec2& a, const Vec2& b, double from, double to) {
  ensure(from < to, "a conic's arc runs from a lower to a higher parameter");
  // The polar form of t and t^2.
  const auto polar = [&](double s, double t) { return Vec2(vertex + 0.5 * (s + t) * a + s * t * b); };
  return {clamped(2, {from, to}), {polar(from, from), polar(from, to), polar(to, to)}, {}};
}

NurbsSurface exact_revolution(const NurbsCurve<2>& profile, double from, double to) {
  const NurbsCurve<2> turn = exact_ellipse(Vec2::Zero(), Vec2::UnitX(), Vec2::UnitY(), from, to);
  NurbsSurface s{turn.t, profile.t, {}, {}};
  for (std::size_t i = 0; i < turn.points.size(); ++i)
    for (std::size_t j = 0; j < profile.points.size(); ++j) {
      const double r = profile.points[j].x();
      ensure(r >= 0, "a profile's radii are not negative");
      s.points.emplace_back(r * turn.points[i].x(), r * turn.points[i].y(), profile.points[j].y());
      s.weights.push_back(turn.weights[i] * (profile.weights.empty() ? 1 : profile.weights[j]));
    }
  return s;
}

NurbsSurface exact_cylinder(double radius, double height) {
  return exact_revolution(straight_profile(Vec2(radius, 0), Vec2(radius, height)), 0, 2 * pi);
}

NurbsSurface exact_cone(double bottom_radius, double top_radius, double height) {
  return exact_revolution(straight_profile(Vec2(bottom_radius, 0), Vec2(top_radius, height)), 0, 2 * pi);
}

NurbsSurface exact_sphere(double radius) {
  NurbsCurve<2> half = exact_ellipse(Vec2::Zero(), Vec2(radius, 0), Vec2(0, radius), -pi / 2, pi / 2);
  half.points.front().x() = half.points.back().x() = 0;  // cos(pi / 2) is not quite 0
  return exact_revolution(half, 0, 2 * pi);
}

NurbsSurface exact_torus(double ring_radius, double tube_radius) {
  ensure(ring_radius > tube_radius, "a torus is a ring around its axis");
  return exact_revolution(exact_ellipse(Vec2(ring_radius, 0), Vec2(tube_radius, 0), Vec2(0, tube_radius), 0, 2 * pi), 0,
                          2 * pi);
}

NurbsSurface exact_ruled(const NurbsCurve<3>& first, const NurbsCurve<3>& second) {
  const int degree = std::max(first.t.degree, second.t.degree);
  const auto ready = [&](const NurbsCurve<3>& c) {
    return with_higher_degree(over_unit(with_clamped_ends(c)), degree - c.t.degree);
  };
  NurbsCurve<3> a = ready(first), b = ready(second);
  a = with_knots_of(a, b.t);
  b = with_knots_of(b, a.t);
  NurbsSurface s{a.t, clamped(1, {0, 1}), {}, {}};
  const bool rational = !a.weights.empty() || !b.weights.empty();
  for (std::size_t i = 0; i < a.points.size(); ++i)
    for (const auto* c : {&a, &b}) {
      s.points.push_back(c->points[i]);
      if (rational) s.weights.push_back(c->weights.empty() ? 1 : c->weights[i]);
    }
  return s;
}

NurbsSurface exact_extrusion(const NurbsCurve<3>& curve, const Vec3& offset) {
  NurbsSurface s{curve.t, clamped(1, {0, 1}), {}, {}};
  for (std::size_t i = 0; i < curve.points.size(); ++i)
    for (const double share : {0.0, 1.0}) {
      s.points.push_back(curve.points[i] + share * offset);
      if (!curve.weights.empty()) s.weights.push_back(curve.weights[i]);
    }
  return s;
}

NurbsCurve<3> posed(const NurbsCurve<3>& curve, const Pose& to_from) { return posed_spline(curve, to_from); }
NurbsSurface posed(const NurbsSurface& surface, const Pose& to_from) { return posed_spline(surface, to_from); }

}  // namespace partscribe::geometry
