#include "model/draft.h"

#include <cmath>

#include "core/ensure.h"
#include "model/sketch.h"

namespace partscribe::model {
namespace {

constexpr double tangent_within = 1e-6;  // rad

Vec2 left_of(const Vec2& along) { return Vec2(-along.y(), along.x()).normalized(); }

/// The unit normal to the left at an end of a line or an arc.
Vec2 left_at(const Curve2& curve, bool at_end) {
  if (const auto* l = std::get_if<Line2>(&curve)) return left_of(l->b - l->a);
  const auto* a = std::get_if<Arc2>(&curve);
  ensure(a != nullptr, "a drafted outline is made of lines and arcs");
  const double angle = at_end ? a->to : a->from;
  return radius_growth(*a) * Vec2(std::cos(angle), std::sin(angle));
}

/// The curve before and after each curve in its loop.
struct Neighbours {
  std::size_t before, after;
};

std::vector<Neighbours> neighbours_of(const Outline2& outline) {
  std::vector<Neighbours> result(outline.curves.size());
  for (std::size_t first = 0; first < outline.curves.size();) {
    std::size_t end = first;
    while (end < outline.curves.size() && outline.curves[end].loop == outline.curves[first].loop) ++end;
    for (std::size_t i = first; i < end; ++i) result[i] = {i == first ? end - 1 : i - 1, i + 1 == end ? first : i + 1};
    first = end;
  }
  return result;
}

/// Where the corner between two straight edges goes when each moves to its left by 1.
Vec2 mitre(const Vec2& n, const Vec2& m) { return (n + m) / (1 + n.dot(m)); }

bool tangent(const Vec2& n, const Vec2& m) { return (n - m).norm() <= tangent_within; }

std::string quoted(const std::string& text) { return "'" + text + "'"; }

}  // namespace

double radius_growth(const Arc2& arc) { return arc.to > arc.from ? -1 : 1; }

std::vector<EndMoves> end_moves(const Outline2& outline) {
  const auto neighbours = neighbours_of(outline);
  std::vector<EndMoves> moves;
  for (std::size_t i = 0; i < outline.curves.size(); ++i) {
    const Curve2& own = outline.curves[i].curve;
    EndMoves m{left_at(own, false), left_at(own, true)};
    if (std::holds_alternative<Line2>(own)) {
      m.start = mitre(left_at(outline.curves[neighbours[i].before].curve, true), m.start);
      m.end = mitre(m.end, left_at(outline.curves[neighbours[i].after].curve, false));
    }
    moves.push_back(m);
  }
  return moves;
}

Outline2 moved_inwards(const Outline2& outline, double by) {
  const auto moves = end_moves(outline);
  Outline2 result = outline;
  for (std::size_t i = 0; i < result.curves.size(); ++i) {
    if (auto* l = std::get_if<Line2>(&result.curves[i].curve))
      l->a += by * moves[i].start, l->b += by * moves[i].end;
    else if (auto* a = std::get_if<Arc2>(&result.curves[i].curve))
      a->radius += by * radius_growth(*a);
  }
  return result;
}

std::optional<std::string> fault_of_draft(const Outline2& outline, double at_bottom, double at_top) {
  const auto neighbours = neighbours_of(outline);
  for (std::size_t i = 0; i < outline.curves.size(); ++i) {
    const auto& own = outline.curves[i];
    if (std::holds_alternative<Nurbs2>(own.curve))
      return "a draft needs lines and arcs, found the curve " + quoted(own.name);
    const auto& next = outline.curves[neighbours[i].after];
    if (std::holds_alternative<Nurbs2>(next.curve)) continue;  // its turn comes
    const Vec2 n = left_at(own.curve, true), m = left_at(next.curve, false);
    const bool lines = std::holds_alternative<Line2>(own.curve) && std::holds_alternative<Line2>(next.curve);
    if (lines ? n.dot(m) < -1 + 1e-9 : !tangent(n, m))
      return "a draft needs arcs that join tangentially, found a corner between " + quoted(own.name) + " and " +
             quoted(next.name);
  }
  const auto moves = end_moves(outline);
  for (std::size_t i = 0; i < outline.curves.size(); ++i) {
    const auto& own = outline.curves[i];
    const auto* l = std::get_if<Line2>(&own.curve);
    const auto* a = std::get_if<Arc2>(&own.curve);
    for (const bool top : {false, true}) {
      const double by = top ? at_top : at_bottom;
      const char* before = top ? " before the top" : " before the bottom";
      if (l && (l->b - l->a).dot(l->b + by * moves[i].end - l->a - by * moves[i].start) <=
                   sketch_join * (l->b - l->a).norm())
        return "with this draft the edge " + quoted(own.name) + " vanishes" + before;
      if (a && a->radius + by * radius_growth(*a) <= sketch_join)
        return "with this draft the radius of " + quoted(own.name) + " comes to nothing" + before;
    }
  }
  return {};
}

}  // namespace partscribe::model
