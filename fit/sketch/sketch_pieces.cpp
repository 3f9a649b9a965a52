#include "fit/sketch/sketch_pieces.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "fit/search/equal_choices.h"

namespace partscribe::fit {

double relation_slack(const SketchOptions& options) { return options.tolerance / 3; }

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

double turned_near(double angle, double near) { return angle + 2 * pi * std::round((near - angle) / (2 * pi)); }

namespace {

/// The lowest flat face on the axis of a revolve, else the centre of an arc on it, else the lowest point.
double start_of_axis(const std::vector<LoopPieces>& loops, const SketchOptions& options) {
  double low = 1e300, lowest = 1e300, best = -1;
  std::optional<double> center;
  for (const auto& loop : loops)
    for (const auto& s : loop.segments) {
      lowest = std::min({lowest, s.start.y(), s.end.y()});
      if (!s.arc && !s.spline && std::abs(s.direction.y()) * s.length() / 2 < relation_slack(options) &&
          s.length() > 4 * options.tolerance)
        low = std::min(low, s.point.y());
      if (s.arc && std::abs(s.center.x()) < std::max(options.tolerance / 2, 0.02 * s.radius) && s.length() > best)
        best = s.length(), center = s.center.y();
    }
  return low < 1e300 ? low : center ? *center : lowest;
}

bool is_circle(const LoopPieces& loop) { return loop.segments.size() == 1 && loop.segments[0].arc; }

/// The box around a loop; of its round parts only what the corners between pieces show, but a circle whole.
std::pair<Vec2, Vec2> extent_of(const LoopPieces& loop) {
  Vec2 low = Vec2::Constant(1e300), high = -low;
  for (const auto& s : loop.segments)
    for (const Vec2& p : {s.start, s.end}) low = low.cwiseMin(p), high = high.cwiseMax(p);
  if (is_circle(loop)) {
    const Vec2 reach = Vec2::Constant(loop.segments[0].radius);
    low = loop.segments[0].center - reach, high = loop.segments[0].center + reach;
  }
  return {low, high};
}

/// The outline's straight edges across an axis that nothing of it goes beyond, at its low and its high end.
std::array<std::optional<double>, 2> outer_edges(const LoopPieces& outline, int axis, const SketchOptions& options) {
  Vec2 low = Vec2::Constant(1e300), high = -low;
  for (const auto& s : outline.segments) {
    low = low.cwiseMin(s.start).cwiseMin(s.end), high = high.cwiseMax(s.start).cwiseMax(s.end);
    if (!s.arc) continue;
    const int quarters = int(std::ceil(std::abs(s.sweep) / 0.1));
    const Vec2 from = s.start - s.center;
    for (int k = 1; k < quarters; ++k) {
      const double turn = s.sweep * k / quarters;
      const Vec2 p = s.center + Vec2(std::cos(turn) * from.x() - std::sin(turn) * from.y(),
                                     std::sin(turn) * from.x() + std::cos(turn) * from.y());
      low = low.cwiseMin(p), high = high.cwiseMax(p);
    }
  }
  std::array<std::optional<double>, 2> edges;
  double longest[2] = {0, 0};
  for (const auto& s : outline.segments) {
    if (s.arc || s.spline || !(std::abs(s.direction[axis]) * s.length() / 2 < relation_slack(options))) continue;
    for (const int end : {0, 1})
      if (std::abs(s.point[axis] - (end == 0 ? low : high)[axis]) < options.tolerance && s.length() > longest[end])
        edges[std::size_t(end)] = s.point[axis], longest[end] = s.length();
  }
  return edges;
}

/// True if every hole has one of its size on the other side of `middle`, or lies on it.
bool lie_evenly(const std::vector<LoopPieces>& loops, int axis, double middle, double same) {
  for (std::size_t i = 1; i < loops.size(); ++i) {
    const auto [low, high] = extent_of(loops[i]);
    bool found = false;
    for (std::size_t k = 1; k < loops.size() && !found; ++k) {
      auto [other_low, other_high] = extent_of(loops[k]);
      std::swap(other_low[axis], other_high[axis]);
      other_low[axis] = 2 * middle - other_low[axis], other_high[axis] = 2 * middle - other_high[axis];
      found =
          (other_low - low).cwiseAbs().maxCoeff() < 2 * same && (other_high - high).cwiseAbs().maxCoeff() < 2 * same;
    }
    if (!found) return false;
  }
  return loops.size() > 1;
}

}  // namespace

SketchOrigin sketch_origin(const std::vector<LoopPieces>& loops, const SketchOptions& options) {
  if (options.revolve) return {{0, start_of_axis(loops, options)}};
  if (is_circle(loops[0])) return {loops[0].segments[0].center};
  std::vector<double> radii;
  std::vector<Vec2> centers;
  for (std::size_t i = 1; i < loops.size(); ++i)
    if (is_circle(loops[i]))
      radii.push_back(loops[i].segments[0].radius), centers.push_back(loops[i].segments[0].center);
  SketchOrigin origin{extent_of(loops[0]).first};
  for (const int axis : {0, 1}) {
    const auto [low, high] = outer_edges(loops[0], axis, options);
    if (low && high && lie_evenly(loops, axis, (*low + *high) / 2, options.tolerance / 5))
      origin.place[axis] = (*low + *high) / 2, origin.middle[std::size_t(axis)] = true;
    else if (low)
      origin.place[axis] = *low;
    else if (!radii.empty())
      origin.place[axis] =
          centers[by_size(radii, in_order(centers, options.tolerance), options.tolerance / 5).front()][axis];
  }
  return origin;
}

std::vector<SketchPiece> sketch_pieces(const LoopPieces& loop, const Vec2& origin, const SketchOptions& options) {
  const double slack = relation_slack(options);
  std::vector<SketchPiece> pieces;
  for (const auto& s : loop.segments) {
    SketchPiece p;
    p.s = s;
    p.s.start -= origin, p.s.end -= origin, p.s.point -= origin, p.s.center -= origin;
    for (auto& c : p.s.curve.points) c -= origin;
    if (s.arc) {
      const Vec2 d = p.s.start - p.s.center;
      p.from0 = std::atan2(d.y(), d.x());
      p.to0 = p.from0 + s.sweep;
    } else if (!s.spline) {
      const double half = p.s.length() / 2;
      if (std::abs(p.s.direction.y()) * half < slack && std::abs(p.s.direction.y()) < 0.25)
        p.way = Way::horizontal;
      else if (std::abs(p.s.direction.x()) * half < slack && std::abs(p.s.direction.x()) < 0.25)
        p.way = Way::vertical;
    }
    pieces.push_back(std::move(p));
  }
  return pieces;
}

void find_levels(std::vector<SketchPiece>& pieces, std::vector<SketchLevel>& levels, double same) {
  for (auto& p : pieces) {
    if (p.way == Way::oblique) continue;
    const int axis = p.way == Way::vertical ? 0 : 1;
    const double v = p.s.point[axis];
    auto found = std::find_if(levels.begin(), levels.end(), [&](const SketchLevel& level) {
      return level.axis == axis && std::abs(level.value - v) < same;
    });
    if (found == levels.end())
      found = levels.insert(levels.end(), SketchLevel{axis, v, 0, 1e300, -1e300, true, {}, false});
    if (p.s.length() > found->length) found->rising = p.s.direction[1 - axis] > 0;
    found->length += p.s.length();
    found->low = std::min({found->low, p.s.start[1 - axis], p.s.end[1 - axis]});
    found->high = std::max({found->high, p.s.start[1 - axis], p.s.end[1 - axis]});
    p.level = static_cast<int>(found - levels.begin());
  }
}

bool centred_on_axis(const SketchPiece& arc, const SketchOptions& options) {
  return options.revolve && std::abs(arc.s.center.x()) < std::max(options.tolerance / 2, 0.02 * arc.s.radius);
}

bool touches(const SketchPiece& arc, double end_angle, const SketchPiece& edge, const SketchOptions& options) {
  if (edge.curved() || edge.way == Way::oblique) return false;
  const int axis = edge.way == Way::vertical ? 0 : 1;
  const double side = arc.s.center[axis] - edge.s.point[axis];
  // The touching point must be where the arc ends, within the uncertainty of a shallow crossing.
  const double touch = axis == 0 ? (side > 0 ? pi : 0.0) : (side > 0 ? -pi / 2 : pi / 2);
  const double off = std::abs(turned_near(touch, end_angle) - end_angle);
  const double miss = std::abs(std::abs(side) - arc.s.radius);
  return (off < 0.35 || off * arc.s.radius < 3 * options.tolerance) &&
         miss < std::max(options.tolerance, 0.03 * arc.s.radius);
}

bool arcs_tangent(const SketchPiece& a, const SketchPiece& b, const SketchOptions& options) {
  const Vec2 ta = Vec2(-std::sin(a.to0), std::cos(a.to0)) * (a.s.sweep > 0 ? 1 : -1);
  const Vec2 tb = Vec2(-std::sin(b.from0), std::cos(b.from0)) * (b.s.sweep > 0 ? 1 : -1);
  const double d = (a.s.center - b.s.center).norm();
  const bool opposite = (a.s.sweep > 0) != (b.s.sweep > 0);
  const double miss =
      opposite ? std::abs(d - a.s.radius - b.s.radius) : std::abs(d - std::abs(a.s.radius - b.s.radius));
  return ta.dot(tb) > 0.9 && miss < std::max(2 * options.tolerance, 0.05 * std::min(a.s.radius, b.s.radius));
}

std::optional<Vec2> crossing_of(const ProfileSegment& a, const ProfileSegment& b) {
  const double c = cross(a.direction, b.direction);
  if (std::abs(c) < 0.02) return {};
  return Vec2(a.point + a.direction * (cross(b.point - a.point, b.direction) / c));
}

const SketchPiece* neighbour(const std::vector<SketchPiece>& pieces, std::size_t i, int step, bool axis_to_axis) {
  const std::size_t n = pieces.size();
  if (n == 1) return nullptr;
  if (axis_to_axis && ((i == 0 && step < 0) || (i + 1 == n && step > 0))) return nullptr;
  return &pieces[(i + n + static_cast<std::size_t>(step + static_cast<int>(n))) % n];
}

bool is_chamfer(const std::vector<SketchPiece>& pieces, std::size_t i, bool axis_to_axis) {
  const SketchPiece& p = pieces[i];
  if (p.curved() || p.way != Way::oblique) return false;
  const SketchPiece* before = neighbour(pieces, i, -1, axis_to_axis);
  const SketchPiece* after = neighbour(pieces, i, +1, axis_to_axis);
  if (!before || !after || before->curved() || after->curved()) return false;
  if (!((before->way == Way::horizontal && after->way == Way::vertical) ||
        (before->way == Way::vertical && after->way == Way::horizontal)))
    return false;
  return p.s.length() < before->s.length() + after->s.length();
}

}  // namespace partscribe::fit
