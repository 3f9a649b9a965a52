#include "geometry/surfaces/curve2.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/ensure.h"
#include "core/number.h"

namespace partscribe::geometry {
namespace {

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

struct Foot {
  double sq_distance;
  Vec2 point;
};

Foot foot_on_segment(const Vec2& a, const Vec2& b, const Vec2& p) {
  const Vec2 d = b - a;
  const double length2 = d.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(d) / length2, 0.0, 1.0) : 0.0;
  const Vec2 q = a + t * d;
  return {(p - q).squaredNorm(), q};
}

/// An arc with everything that a query needs again and again.
struct PreparedArc {
  Vec2 center, start, end;
  double radius, low, span;
  Vec2 middle;       // unit, towards the middle of the arc
  double cos_half;   // cosine of half the span; -2 for a full turn
  struct Monotone {  // a piece that rises or falls throughout
    double y0, y1;
    bool right_half;
  };
  std::vector<Monotone> pieces;
};

PreparedArc prepared(const Arc2& arc) {
  PreparedArc p;
  p.center = arc.center, p.radius = arc.radius, p.start = arc.at(arc.from), p.end = arc.at(arc.to);
  p.low = std::min(arc.from, arc.to);
  p.span = std::min(std::abs(arc.to - arc.from), 2 * pi);
  const double high = p.low + p.span, half = p.low + 0.5 * p.span;
  p.middle = {std::cos(half), std::sin(half)};
  p.cos_half = p.span >= 2 * pi - 1e-12 ? -2 : std::cos(0.5 * p.span);
  // Split at the lowest and highest points of the circle.
  std::vector<double> cuts = {p.low};
  for (double k = std::ceil((p.low - pi / 2) / pi); pi / 2 + k * pi < high; k += 1)
    if (pi / 2 + k * pi > p.low) cuts.push_back(pi / 2 + k * pi);
  cuts.push_back(high);
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i)
    p.pieces.push_back({arc.at(cuts[i]).y(), arc.at(cuts[i + 1]).y(), std::cos(0.5 * (cuts[i] + cuts[i + 1])) > 0});
  // sin(2 pi) is not sin(0): between the two a ray would slip through the circle.
  if (p.cos_half == -2) p.pieces.back().y1 = p.pieces.front().y0;
  return p;
}

Foot foot_on_arc(const PreparedArc& arc, const Vec2& p) {
  const Vec2 d = p - arc.center;
  const double rho = d.norm();
  if (rho <= 0) return {arc.radius * arc.radius, arc.start};
  if (arc.middle.dot(d) >= arc.cos_half * rho) {
    const double off = rho - arc.radius;
    return {off * off, arc.center + d * (arc.radius / rho)};
  }
  const double da = (p - arc.start).squaredNorm(), db = (p - arc.end).squaredNorm();
  return da <= db ? Foot{da, arc.start} : Foot{db, arc.end};
}

/// How often a ray from p to the right crosses the arc.
int crossings(const PreparedArc& arc, const Vec2& p) {
  if (std::abs(p.y() - arc.center.y()) > arc.radius || p.x() > arc.center.x() + arc.radius) return 0;
  int count = 0;
  for (const auto& piece : arc.pieces) {
    if ((piece.y0 <= p.y()) == (piece.y1 <= p.y())) continue;
    const double dy = p.y() - arc.center.y();
    const double half_width = std::sqrt(std::max(arc.radius * arc.radius - dy * dy, 0.0));
    if (arc.center.x() + (piece.right_half ? half_width : -half_width) > p.x()) ++count;
  }
  return count;
}

int crossings(const Vec2& a, const Vec2& b, const Vec2& p) {
  if ((a.y() <= p.y()) == (b.y() <= p.y())) return 0;
  return a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()) > p.x() ? 1 : 0;
}

}  // namespace

Vec2 Arc2::at(double angle) const { return center + radius * Vec2(std::cos(angle), std::sin(angle)); }

Vec2 start_of(const Curve2& curve) {
  if (const auto* l = std::get_if<Line2>(&curve)) return l->a;
  if (const auto* a = std::get_if<Arc2>(&curve)) return a->at(a->from);
  return std::get<Nurbs2>(curve).points.front();
}

Vec2 end_of(const Curve2& curve) {
  if (const auto* l = std::get_if<Line2>(&curve)) return l->b;
  if (const auto* a = std::get_if<Arc2>(&curve)) return a->at(a->to);
  return std::get<Nurbs2>(curve).points.back();
}

namespace {

void refine_nurbs(const Nurbs2& c, double u0, const Vec2& p0, double u1, const Vec2& p1, double error, int depth,
                  std::vector<double>& us) {
  const double um = 0.5 * (u0 + u1);
  const Vec2 pm = c.at(um);
  const double third = std::max(foot_on_segment(p0, p1, c.at(u0 + (u1 - u0) * 0.29)).sq_distance,
                                foot_on_segment(p0, p1, c.at(u0 + (u1 - u0) * 0.71)).sq_distance);
  const double worst = std::max(foot_on_segment(p0, p1, pm).sq_distance, third);
  if (depth < 16 && worst > error * error) {
    refine_nurbs(c, u0, p0, um, pm, error, depth + 1, us);
    refine_nurbs(c, um, pm, u1, p1, error, depth + 1, us);
  } else {
    us.push_back(u1);
  }
}

std::vector<double> nurbs_parameters(const Nurbs2& c, double error) {
  const auto breaks = c.t.breaks();
  std::vector<double> us = {breaks.front()};
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
    refine_nurbs(c, breaks[i], c.at(breaks[i]), breaks[i + 1], c.at(breaks[i + 1]), error, 0, us);
  return us;
}

}  // namespace

std::vector<Vec2> polyline(const Curve2& curve, double chord_error) {
  if (const auto* l = std::get_if<Line2>(&curve)) return {l->a, l->b};
  if (const auto* a = std::get_if<Arc2>(&curve)) {
    const double step = 2 * std::acos(std::clamp(1 - chord_error / a->radius, 0.0, 1.0));
    const int pieces = std::max(2, static_cast<int>(std::ceil(std::abs(a->to - a->from) / std::max(step, 1e-3))));
    std::vector<Vec2> points;
    for (int i = 0; i <= pieces; ++i) points.push_back(a->at(a->from + (a->to - a->from) * i / pieces));
    return points;
  }
  const auto& c = std::get<Nurbs2>(curve);
  std::vector<Vec2> points;
  for (const double u : nurbs_parameters(c, chord_error)) points.push_back(c.at(u));
  return points;
}

struct OutlineDistance::Prepared {
  std::vector<PreparedArc> arcs;  // one per curve; meaningful for arcs only
};

OutlineDistance::~OutlineDistance() = default;
OutlineDistance::OutlineDistance(OutlineDistance&&) noexcept = default;

OutlineDistance::OutlineDistance(Outline2 outline)
    : outline_(std::move(outline)),
      ignored_(outline_.curves.size(), 0),
      chords_(outline_.curves.size()),
      chord_u_(outline_.curves.size()),
      prepared_(std::make_unique<Prepared>()) {
  for (const auto& c : outline_.curves) {
    const auto* a = std::get_if<Arc2>(&c.curve);
    prepared_->arcs.push_back(a ? prepared(*a) : PreparedArc{});
  }
  double size = 0;
  Vec2 low = Vec2::Constant(1e300), high = Vec2::Constant(-1e300);
  for (const auto& c : outline_.curves)
    for (const auto& p : {start_of(c.curve), end_of(c.curve)}) low = low.cwiseMin(p), high = high.cwiseMax(p);
  size = (high - low).norm();
  chord_error_ = std::max(1e-3 * size, 1e-9);
  for (std::size_t i = 0; i < outline_.curves.size(); ++i)
    if (const auto* c = std::get_if<Nurbs2>(&outline_.curves[i].curve)) {
      chord_u_[i] = nurbs_parameters(*c, chord_error_);
      for (const double u : chord_u_[i]) chords_[i].push_back(c->at(u));
    }
}

bool OutlineDistance::inside(const Vec2& p) const {
  int count = 0;
  for (std::size_t i = 0; i < outline_.curves.size(); ++i) {
    const auto& curve = outline_.curves[i].curve;
    if (const auto* l = std::get_if<Line2>(&curve)) {
      count += crossings(l->a, l->b, p);
    } else if (std::holds_alternative<Arc2>(curve)) {
      count += crossings(prepared_->arcs[i], p);
    } else {
      for (std::size_t k = 0; k + 1 < chords_[i].size(); ++k) count += crossings(chords_[i][k], chords_[i][k + 1], p);
    }
  }
  return count % 2 == 1;
}

struct OutlineDistance::NurbsFoot {
  Vec2 point, tangent;
  bool within;  // between the curve's ends
};

OutlineDistance::NurbsFoot OutlineDistance::nurbs_foot(const Vec2& p, std::size_t curve) const {
  const auto& c = std::get<Nurbs2>(outline_.curves[curve].curve);
  const auto& chords = chords_[curve];
  Foot foot{1e300, p};
  std::size_t at = 0;
  for (std::size_t k = 0; k + 1 < chords.size(); ++k) {
    const Foot chord = foot_on_segment(chords[k], chords[k + 1], p);
    if (chord.sq_distance < foot.sq_distance) foot = chord, at = k;
  }
  const double u0 = chord_u_[curve][at], u1 = chord_u_[curve][at + 1];
  const double length = (chords[at + 1] - chords[at]).norm();
  double u = length > 0 ? u0 + (u1 - u0) * (foot.point - chords[at]).norm() / length : u0;
  Vec2 q, d1, d2;
  for (int k = 0; k < 8; ++k) {
    c.derivatives(u, q, d1, d2);
    const double g = d1.dot(q - p), h = d1.squaredNorm() + d2.dot(q - p);
    const double step = -g / (h > 0 ? h : std::max(d1.squaredNorm(), 1e-300));
    u = std::clamp(u + step, c.t.low(), c.t.high());
    if (std::abs(step) < 1e-12 * (c.t.high() - c.t.low())) break;
  }
  c.derivatives(u, q, d1, d2);
  return {q, d1, u > c.t.low() && u < c.t.high()};
}

OutlineDistance::CurveFoot OutlineDistance::foot(const Vec2& p, int curve) const {
  const std::size_t i = static_cast<std::size_t>(curve);
  CurveFoot result;
  Vec2 along;
  if (const auto* l = std::get_if<Line2>(&outline_.curves[i].curve)) {
    result.point = foot_on_segment(l->a, l->b, p).point;
    along = l->b - l->a;
  } else if (const auto* a = std::get_if<Arc2>(&outline_.curves[i].curve)) {
    result.point = foot_on_arc(prepared_->arcs[i], p).point;
    const Vec2 out = result.point - a->center;
    along = Vec2(-out.y(), out.x());
  } else {
    const NurbsFoot on_curve = nurbs_foot(p, i);
    result.point = on_curve.point, along = on_curve.tangent;
  }
  result.distance = (p - result.point).norm();
  if (along.squaredNorm() > 0) result.normal = Vec2(along.y(), -along.x()).normalized();
  return result;
}

OutlineDistance::Hit OutlineDistance::operator()(const Vec2& p) const {
  Hit hit;
  double best = 1e300;
  Vec2 nurbs_normal = Vec2::Zero();  // of the nearest curve, when it is a NURBS
  for (std::size_t i = 0; i < outline_.curves.size(); ++i) {
    if (ignored_[i]) continue;
    const auto& curve = outline_.curves[i].curve;
    Foot foot{1e300, p};
    Vec2 normal = Vec2::Zero();
    if (const auto* l = std::get_if<Line2>(&curve)) {
      foot = foot_on_segment(l->a, l->b, p);
    } else if (std::holds_alternative<Arc2>(curve)) {
      foot = foot_on_arc(prepared_->arcs[i], p);
    } else {
      const NurbsFoot on_curve = nurbs_foot(p, i);
      foot = {(p - on_curve.point).squaredNorm(), on_curve.point};
      // Beyond its ends a curve's normal tells no side.
      if (on_curve.within) normal = Vec2(on_curve.tangent.y(), -on_curve.tangent.x());
    }
    if (foot.sq_distance < best) {
      best = foot.sq_distance;
      hit.curve = static_cast<int>(i);
      hit.foot = foot.point;
      nurbs_normal = normal;
    }
  }
  ensure(hit.curve >= 0, "an outline has at least one curve that is a surface");
  hit.distance = std::sqrt(best);
  bool is_inside = inside(p);
  // Chords decide the inside only coarsely; close to a NURBS its own normal does (right of it is outside).
  if (nurbs_normal.squaredNorm() > 0 && hit.distance > 0 && hit.distance < 2 * chord_error_) {
    const double side = nurbs_normal.normalized().dot(p - hit.foot) / hit.distance;
    if (std::abs(side) > 0.9) is_inside = side < 0;
  }
  if (is_inside) hit.distance = -hit.distance;
  return hit;
}

double signed_area(const Outline2& outline, int loop) {
  double sum = 0;
  for (const auto& c : outline.curves) {
    if (c.loop != loop) continue;
    const auto points = polyline(c.curve, 1e-3);
    for (std::size_t i = 0; i + 1 < points.size(); ++i) sum += cross(points[i], points[i + 1]);
    if (const auto* a = std::get_if<Arc2>(&c.curve)) {
      // What lies between the chords and the arc, exactly.
      const double step = (a->to - a->from) / static_cast<double>(points.size() - 1);
      sum += static_cast<double>(points.size() - 1) * a->radius * a->radius * (step - std::sin(step));
    }
  }
  return 0.5 * sum;
}

}  // namespace partscribe::geometry
