#include "fit/sketch_pieces.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "fit/equal_choices.h"

namespace partscribe {

double relation_slack(const SketchOptions& options) { return options.tolerance / 3; }

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

double turned_near(double angle, double near) { return angle + 2 * pi * std::round((near - angle) / (2 * pi)); }

Vec2 sketch_origin(const std::vector<LoopPieces>& loops, const SketchOptions& options) {
  const double slack = relation_slack(options);
  double best = -1;
  if (options.revolve) {
    double low = 1e300, lowest = 1e300;
    std::optional<double> center;
    for (const auto& loop : loops)
      for (const auto& s : loop.segments) {
        lowest = std::min({lowest, s.start.y(), s.end.y()});
        if (!s.arc && !s.spline && std::abs(s.direction.y()) * s.length() / 2 < slack &&
            s.length() > 4 * options.tolerance)
          low = std::min(low, s.point.y());
        if (s.arc && std::abs(s.center.x()) < std::max(options.tolerance / 2, 0.02 * s.radius) && s.length() > best)
          best = s.length(), center = s.center.y();
      }
    return {0, low < 1e300 ? low : center ? *center : lowest};
  }
  Vec2 origin = Vec2::Zero();
  std::vector<double> radii;
  std::vector<Vec2> centers;
  for (const auto& loop : loops)
    if (loop.segments.size() == 1 && loop.segments[0].arc && (&loop != &loops[0] || loops.size() == 1))
      radii.push_back(loop.segments[0].radius), centers.push_back(loop.segments[0].center);
  if (!radii.empty()) {
    const std::size_t first = by_size(radii, in_order(centers, options.tolerance), options.tolerance / 5).front();
    best = radii[first], origin = centers[first];
  }
  if (best < 0) {
    Vec2 low = Vec2::Constant(1e300);
    for (const auto& s : loops[0].segments) {
      low = low.cwiseMin(s.start).cwiseMin(s.end);
      if (s.arc || s.spline) continue;
      if (std::abs(s.direction.x()) * s.length() / 2 < slack) low.x() = std::min(low.x(), s.point.x());
      if (std::abs(s.direction.y()) * s.length() / 2 < slack) low.y() = std::min(low.y(), s.point.y());
    }
    // Corners are means of nodes and lie a little inside: the level of the edge itself is meant.
    Vec2 edge = low;
    for (const auto& s : loops[0].segments) {
      if (s.arc || s.spline) continue;
      if (std::abs(s.direction.x()) * s.length() / 2 < slack && std::abs(s.point.x() - low.x()) < options.tolerance)
        edge.x() = s.point.x();
      if (std::abs(s.direction.y()) * s.length() / 2 < slack && std::abs(s.point.y() - low.y()) < options.tolerance)
        edge.y() = s.point.y();
    }
    origin = edge;
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
    for (auto& c : p.s.curve.control) c -= origin;
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

}  // namespace partscribe
