#include "model/sketch_relations.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"

namespace partscribe::model {
namespace {

constexpr double holds_within = 1e-6;  // mm, rad

Vec2 unit(const Vec2& v) { return v.normalized(); }

/// Direction of travel at an end of a curve.
Vec2 direction(const Curve2& curve, bool at_end) {
  if (const auto* l = std::get_if<Line2>(&curve)) return unit(l->b - l->a);
  if (const auto* a = std::get_if<Arc2>(&curve)) {
    const double angle = at_end ? a->to : a->from;
    const Vec2 ccw(-std::sin(angle), std::cos(angle));
    return a->to > a->from ? ccw : Vec2(-ccw);
  }
  const auto& n = std::get<Nurbs2>(curve);
  Vec2 point, first, second;
  n.derivatives(at_end ? n.t.high() : n.t.low(), point, first, second);
  return unit(first);
}

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Length of a straight edge or radius of an arc; nothing for others.
std::optional<double> size_of(const Curve2& curve) {
  if (const auto* l = std::get_if<Line2>(&curve)) return (l->b - l->a).norm();
  if (const auto* a = std::get_if<Arc2>(&curve)) return a->radius;
  return {};
}

/// How far two curves are from running in one direction where an end of one meets an end of the other; nothing if no
/// ends meet.
std::optional<double> kink(const Curve2& a, const Curve2& b) {
  std::optional<double> least;
  for (const bool a_end : {false, true})
    for (const bool b_end : {false, true}) {
      const Vec2 p = a_end ? end_of(a) : start_of(a), q = b_end ? end_of(b) : start_of(b);
      if ((p - q).norm() > holds_within) continue;
      const double off = std::abs(cross(direction(a, a_end), direction(b, b_end)));
      if (!least || off < *least) least = off;
    }
  return least;
}

/// How far one curve is from the image of the other; the image runs the other way.
double image_gap(const Curve2& a, const Curve2& b, int axis) {
  auto image = [&](Vec2 p) {
    p[axis] = -p[axis];
    return p;
  };
  double gap = std::max((image(start_of(a)) - end_of(b)).norm(), (image(end_of(a)) - start_of(b)).norm());
  gap = std::min(gap, std::max((image(start_of(a)) - start_of(b)).norm(), (image(end_of(a)) - end_of(b)).norm()));
  const auto *p = std::get_if<Arc2>(&a), *q = std::get_if<Arc2>(&b);
  if (p && q) gap = std::max({gap, std::abs(p->radius - q->radius), (image(p->center) - q->center).norm()});
  return gap;
}

}  // namespace

std::optional<std::string> fault_of(const SketchRelation& r, const Outline2& outline) {
  const std::string named = "relation " + r.kind + " of '" + r.first + "' and '" + r.second + "': ";
  std::vector<const Curve2*> both;
  for (const auto& role : {r.first, r.second}) {
    const auto count = std::count_if(outline.curves.begin(), outline.curves.end(),
                                     [&](const OutlineCurve& c) { return c.name == role; });
    if (count != 1) return named + "expected one piece called '" + role + "', found " + print_number(double(count));
    both.push_back(&std::find_if(outline.curves.begin(), outline.curves.end(), [&](const OutlineCurve& c) {
                      return c.name == role;
                    })->curve);
  }
  const Curve2 &a = *both[0], &b = *both[1];
  const bool lines = std::holds_alternative<Line2>(a) && std::holds_alternative<Line2>(b);
  const auto *p = std::get_if<Arc2>(&a), *q = std::get_if<Arc2>(&b);
  std::optional<double> off;
  if (r.kind == "parallel" || r.kind == "perpendicular") {
    if (!lines) return named + "both have to be straight edges";
    const Vec2 u = direction(a, false), v = direction(b, false);
    off = std::abs(r.kind == "parallel" ? cross(u, v) : u.dot(v));
  } else if (r.kind == "tangent") {
    off = kink(a, b);
    if (!off) return named + "the pieces do not meet";
  } else if (r.kind == "equal") {
    const auto first = size_of(a), second = size_of(b);
    if (!first || !second || a.index() != b.index()) return named + "both have to be straight edges, or arcs";
    off = std::abs(*first - *second);
  } else if (r.kind == "concentric") {
    if (!p || !q) return named + "both have to be arcs";
    off = (p->center - q->center).norm();
  } else if (r.kind == "symmetric_x" || r.kind == "symmetric_y") {
    if (a.index() != b.index()) return named + "the pieces are not alike";
    // Behind the x axis y changes its sign.
    off = image_gap(a, b, r.kind == "symmetric_x" ? 1 : 0);
  } else {
    return named +
           "expected parallel, perpendicular, tangent, equal, concentric, symmetric_x or symmetric_y as its kind";
  }
  if (*off <= holds_within) return {};
  return named + "the numbers contradict it by " + print_number(snapped(*off, 1e-6));
}

}  // namespace partscribe::model
