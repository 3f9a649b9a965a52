#include "fit/sketch/sketch_builder.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "core/number.h"
#include "fit/sketch/sketch_layout.h"
#include "fit/sketch/sketch_names.h"
#include "fit/sketch/sketch_pieces.h"

namespace partscribe::fit {
namespace {

using Piece = SketchPiece;
using Level = SketchLevel;

class Builder {
 public:
  Builder(std::vector<LoopPieces> loops, const SketchOptions& options)
      : loops_(std::move(loops)), o_(options), same_(options.tolerance / 5), numbers_(same_) {}

  BuiltSketch build() {
    const SketchOrigin origin = sketch_origin(loops_, o_);
    origin_ = origin.place;
    for (const auto& loop : loops_) pieces_.push_back(sketch_pieces(loop, origin_, o_));
    for (auto& pieces : pieces_) find_levels(pieces, levels_, same_);
    if (!o_.revolve) place_by_sizes(numbers_, levels_, pieces_, origin.middle);
    for (std::size_t l = 0; l < pieces_.size(); ++l) mark_tangents(pieces_[l], loops_[l].axis_to_axis);
    for (std::size_t l = 0; l < pieces_.size(); ++l) solve_arcs(pieces_[l], loops_[l].axis_to_axis);
    for (std::size_t l = 0; l < pieces_.size(); ++l) emit(pieces_[l], loops_[l]);
    result_.parameters = std::move(numbers_.parameters);
    tell_chamfers();
    name_parameters(result_, numbers_.slots, levels_, pieces_, o_);
    result_.origin = origin_;
    return std::move(result_);
  }

 private:
  // ---- numbers -----------------------------------------------------------------------------------------------------

  Expr parameter(double value, Quantity quantity, std::string role, std::string note) {
    return numbers_.parameter(value, quantity, std::move(role), std::move(note));
  }
  double value(const Expr& e) const { return numbers_.value(e); }
  Expr coordinate(int axis, double v, const std::string& role, const std::string& note) {
    return numbers_.coordinate(axis, v, role, note);
  }

  Expr radius(double v, const std::string& role, const std::string& note) {
    return numbers_.shared(radii_, v, role, note);
  }

  // ---- levels ------------------------------------------------------------------------------------------------------

  Expr level_expr(int index) {
    Level& level = levels_[static_cast<std::size_t>(index)];
    if (!level.set) {
      level.set = true;
      const bool x = level.axis == 0;
      std::string role, note;
      if (o_.revolve && x) {
        role = level.rising ? "body_radius" : "bore_radius";
        note = level.rising ? "radius of the cylinder from z = " : "radius of the bore from z = ";
        note += text(level.low) + " to " + text(level.high);
      } else if (o_.revolve) {
        role = "shoulder_z", note = "height of a flat face";
      } else {
        role = x ? "edge_x" : "edge_y", note = x ? "position of an edge along x" : "position of an edge along y";
      }
      level.expr = coordinate(level.axis, level.value, role, note);
    }
    return level.expr;
  }

  std::string text(double v) const {
    return print_number(snapped(v, power_of_ten_below(std::max(o_.tolerance, 1e-6))));
  }

  void mark_tangents(std::vector<Piece>& pieces, bool axis_to_axis) {
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      Piece& a = pieces[i];
      if (!a.s.arc) continue;
      auto tangent_to = [&](const Piece* b, double end_angle) { return b && touches(a, end_angle, *b, o_); };
      a.tangent_start = tangent_to(neighbour(pieces, i, -1, axis_to_axis), a.from0);
      a.tangent_end = tangent_to(neighbour(pieces, i, +1, axis_to_axis), a.to0);
    }
  }

  std::size_t index_of(const std::vector<Piece>& pieces, std::size_t i, int step) const {
    return (i + pieces.size() + static_cast<std::size_t>(step + static_cast<int>(pieces.size()))) % pieces.size();
  }

  /// The reference of an arc whose centre follows from a tangent neighbouring arc: -1 before, +1 after, 0 none. The
  /// freer of two tangent arcs depends on the other; of two equally free ones the later.
  int reference_of(const std::vector<Piece>& pieces, std::size_t i, bool axis_to_axis) const {
    const Piece& a = pieces[i];
    if (!a.s.arc || centred_on_axis(a, o_) || (a.tangent_start && a.tangent_end)) return 0;
    auto freedom = [&](const Piece& p) {
      return 2 - int(centred_on_axis(p, o_)) - int(p.tangent_start) - int(p.tangent_end);
    };
    for (const int step : {-1, +1}) {
      const Piece* b = neighbour(pieces, i, step, axis_to_axis);
      if (!b || !b->s.arc || b == &a) continue;
      if (step < 0 ? a.tangent_start : a.tangent_end) continue;
      if (!(step < 0 ? arcs_tangent(*b, a, o_) : arcs_tangent(a, *b, o_))) continue;
      if (freedom(a) > freedom(*b) || centred_on_axis(*b, o_) ||
          (freedom(a) == freedom(*b) && step < 0 && index_of(pieces, i, -1) < i))
        return step;
    }
    return 0;
  }

  /// An arc that touches a solved arc and, at its other end, perhaps a level: the centre follows from the radius alone
  /// (with a level) or from the radius and the angle of the joint.
  void solve_dependent(std::vector<Piece>& pieces, std::size_t i, int step, bool axis_to_axis) {
    Piece& a = pieces[i];
    Piece& b = pieces[index_of(pieces, i, step)];
    const bool opposite = (a.s.sweep > 0) != (b.s.sweep > 0);
    a.name = a.s.sweep > 0 ? "round" : "fillet";
    a.r = radius(a.s.radius, a.name + "_radius", "radius of the " + a.name);
    // Distance of the centres, and on which side of b's centre the joint lies (b outside: the same side as a).
    const bool a_larger = !opposite && a.s.radius > b.s.radius;
    const Expr apart = opposite ? b.r + a.r : a_larger ? a.r - b.r : b.r - a.r;
    const Piece* line = step < 0 ? (a.tangent_end ? neighbour(pieces, i, +1, axis_to_axis) : nullptr)
                                 : (a.tangent_start ? neighbour(pieces, i, -1, axis_to_axis) : nullptr);
    Expr joint_b;  // angle of the joint seen from b
    if (line) {
      const int axis = line->way == Way::vertical ? 0 : 1;
      const double sign = a.s.center[axis] > line->s.point[axis] ? 1 : -1;
      const Expr fixed = sign > 0 ? level_expr(line->level) + a.r : level_expr(line->level) - a.r;
      const Expr& b_fixed = axis == 0 ? b.cx : b.cy;
      const Expr& b_free = axis == 0 ? b.cy : b.cx;
      const Expr d = fixed - b_fixed;
      const Expr root = Expr::call(Expr::Kind::sqrt, {apart * apart - d * d});
      const Expr free = a.s.center[1 - axis] >= value(b_free) ? b_free + root : b_free - root;
      (axis == 0 ? a.cx : a.cy) = fixed;
      (axis == 0 ? a.cy : a.cx) = free;
      // From b's centre towards a's, or away from it when b lies inside a.
      joint_b = a_larger ? Expr::call(Expr::Kind::atan2, {b.cy - a.cy, b.cx - a.cx})
                         : Expr::call(Expr::Kind::atan2, {a.cy - b.cy, a.cx - b.cx});
    } else {
      Vec2 direction = a.s.center - b.s.center;
      if (a_larger) direction = -direction;
      const double measured = turned_near(std::atan2(direction.y(), direction.x()), step < 0 ? b.to0 : b.from0);
      joint_b =
          parameter(measured, Quantity::angle, a.name + "_joint_angle", "angle at which the " + a.name + " begins");
      const Expr along = a_larger ? -apart : apart;
      a.cx = b.cx + along * Expr::call(Expr::Kind::cos, {joint_b});
      a.cy = b.cy + along * Expr::call(Expr::Kind::sin, {joint_b});
    }
    // Seen from a the joint lies opposite when the arcs curve to different sides.
    const Expr joint_a =
        opposite ? (line ? Expr::call(Expr::Kind::atan2, {b.cy - a.cy, b.cx - a.cx}) : joint_b + Expr(pi)) : joint_b;
    (step < 0 ? a.joint_start : a.joint_end) = joint_a;
    (step < 0 ? b.joint_end : b.joint_start) = joint_b;
    a.solved = true;
  }

  void solve_arcs(std::vector<Piece>& pieces, bool axis_to_axis) {
    std::vector<int> reference(pieces.size(), 0);
    for (std::size_t i = 0; i < pieces.size() && pieces.size() > 1; ++i)
      reference[i] = reference_of(pieces, i, axis_to_axis);
    // Two arcs that wait for each other: the first stands alone.
    for (std::size_t i = 0; i < pieces.size(); ++i)
      if (reference[i] > 0 && reference[index_of(pieces, i, +1)] < 0) reference[i] = 0;
    for (std::size_t i = 0; i < pieces.size(); ++i)
      if (pieces[i].s.arc && reference[i] == 0) solve_arc(pieces, i, axis_to_axis);
    for (bool progress = true; progress;) {
      progress = false;
      for (std::size_t i = 0; i < pieces.size(); ++i)
        if (pieces[i].s.arc && !pieces[i].solved && pieces[index_of(pieces, i, reference[i])].solved) {
          solve_dependent(pieces, i, reference[i], axis_to_axis);
          progress = true;
        }
    }
    for (std::size_t i = 0; i < pieces.size(); ++i)
      if (pieces[i].s.arc && !pieces[i].solved) solve_arc(pieces, i, axis_to_axis);
    // Ends come last: they look at neighbours on both sides.
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      Piece& a = pieces[i];
      if (!a.s.arc || pieces.size() == 1) continue;
      a.from = end_angle(a, neighbour(pieces, i, -1, axis_to_axis), a.tangent_start, a.from0, axis_to_axis && i == 0,
                         a.joint_start);
      a.to = end_angle(a, neighbour(pieces, i, +1, axis_to_axis), a.tangent_end, a.to0,
                       axis_to_axis && i + 1 == pieces.size(), a.joint_end);
    }
  }

  void solve_arc(std::vector<Piece>& pieces, std::size_t i, bool axis_to_axis) {
    Piece& a = pieces[i];
    a.solved = true;
    const bool convex = a.s.sweep > 0;
    if (pieces.size() == 1) return full_circle(a, loops_[static_cast<std::size_t>(&pieces - pieces_.data())].name);
    const bool centred = centred_on_axis(a, o_);
    const Piece* before = neighbour(pieces, i, -1, axis_to_axis);
    const Piece* after = neighbour(pieces, i, +1, axis_to_axis);
    std::vector<const Piece*> touched;
    if (a.tangent_start) touched.push_back(before);
    if (a.tangent_end && (touched.empty() || after->level != touched[0]->level)) touched.push_back(after);
    auto side = [&](const Piece& line) {
      const int axis = line.way == Way::vertical ? 0 : 1;
      return a.s.center[axis] > line.s.point[axis] ? 1.0 : -1.0;
    };
    const bool parallel = touched.size() == 2 && touched[0]->way == touched[1]->way;
    const char* bend = touched.size() == 2 ? (convex ? "round" : "fillet") : (convex ? "bulge" : "groove");
    const std::string role = centred ? "dome" : parallel ? "end" : bend;
    a.name = role;
    const std::string where = " of the " + role;
    std::optional<Expr> cx, cy;
    if (centred) cx = Expr(0);
    if (parallel) {
      // Between two parallel edges: half their distance.
      const int axis = touched[0]->way == Way::vertical ? 0 : 1;
      int low = touched[0]->level, high = touched[1]->level;
      if (levels_[low].value > levels_[high].value) std::swap(low, high);
      const auto key = std::make_pair(low, high);
      auto& center = axis == 0 ? cx : cy;
      auto unknown = [&](int level) { return !levels_[level].set && !numbers_.knows(axis, levels_[level].value); };
      const double middle = (levels_[low].value + levels_[high].value) / 2;
      const std::optional<Expr> datum = numbers_.known(axis, middle);
      if (const auto found = half_widths_.find(key); found != half_widths_.end()) {
        a.r = found->second.first;
        center = found->second.second;
      } else if (unknown(low) && unknown(high) && datum) {
        // Both edges lie half a width from a place that has a name already.
        const Expr place = *datum;
        a.r = radius((levels_[high].value - levels_[low].value) / 2, "end_radius", "radius of the round end");
        for (const auto& [level, at] : {std::pair{low, place - a.r}, std::pair{high, place + a.r}}) {
          levels_[level].expr = at;
          levels_[level].set = true;
          numbers_.know(axis, levels_[level].value, at);
        }
        center = place;
      } else if (unknown(high)) {
        a.r = radius((levels_[high].value - levels_[low].value) / 2, "end_radius", "radius of the round end");
        levels_[high].expr = level_expr(low) + Expr(2) * a.r;
        levels_[high].set = true;
        numbers_.know(axis, levels_[high].value, levels_[high].expr);
      } else {
        a.r = (level_expr(high) - level_expr(low)) / Expr(2);
      }
      if (!center) center = level_expr(low) + a.r;
      half_widths_[key] = {a.r, *center};
    } else {
      if (centred && touched.size() == 1 && touched[0]->way == Way::vertical)
        a.r = level_expr(touched[0]->level);  // a dome on its cylinder
      else
        a.r = radius(a.s.radius, role + "_radius", "radius" + where);
      for (const Piece* line : touched) {
        const int axis = line->way == Way::vertical ? 0 : 1;
        auto& c = axis == 0 ? cx : cy;
        if (c) continue;
        c = side(*line) > 0 ? level_expr(line->level) + a.r : level_expr(line->level) - a.r;
      }
    }
    const char* second = o_.revolve ? "z" : "y";
    const char* first = o_.revolve ? "r" : "x";
    if (!cx)
      cx = coordinate(0, a.s.center.x(), role + "_center_" + first,
                      (o_.revolve ? "distance of the centre from the axis" : "x of the centre") + where);
    const bool around = o_.revolve && touched.empty() && !centred;  // a groove or bulge, around the part
    if (!cy)
      cy = coordinate(1, a.s.center.y(), role + (around ? "_" : "_center_") + second,
                      std::string(o_.revolve ? "height" : "y") + " of the centre" + where);
    a.cx = *cx, a.cy = *cy;
  }

  /// Numbers of the second hole and on are its loop's, so that hole_3_radius is of hole 3.
  void full_circle(Piece& a, const std::string& loop) {
    const bool hole = a.s.sweep < 0;
    const std::string kind = hole ? "hole" : "disc";
    const std::string number = loop.starts_with(kind + " ") ? loop.substr(kind.size() + 1) : "";
    const std::string role = number.empty() || number == "1" ? kind : kind + "_" + number;
    const std::string which = number.empty() ? "the " + kind : kind + " " + number;
    a.name = "";
    a.r = radius(a.s.radius, role + "_radius", "radius of " + which);
    a.cx = coordinate(0, a.s.center.x(), o_.revolve ? "ring_radius" : role + "_x",
                      o_.revolve ? "distance of the centre from the axis" : "x of " + which);
    a.cy =
        coordinate(1, a.s.center.y(), role + (o_.revolve ? "_z" : "_y"), (o_.revolve ? "height of " : "y of ") + which);
    a.from = Expr(hole ? 2 * pi : 0.0);
    a.to = Expr(hole ? 0.0 : 2 * pi);
  }

  /// The angle at which an arc ends on its neighbour.
  Expr end_angle(const Piece& a, const Piece* b, bool tangent, double measured, bool at_axis,
                 const std::optional<Expr>& joint) {
    auto near = [&](Expr e) {
      const double v = value(e);
      const double turns = std::round((measured - v) / (2 * pi));
      return turns == 0 ? e : e + Expr(2 * pi * turns);
    };
    if (joint) return near(*joint);
    const double cx = value(a.cx), cy = value(a.cy), r = value(a.r);
    auto crossing_x = [&](const Expr& x) {
      Expr c = Expr::call(Expr::Kind::acos, {(x - a.cx) / a.r});
      return std::sin(measured) >= 0 ? near(c) : near(-c);
    };
    auto crossing_y = [&](const Expr& y) {
      Expr s = Expr::call(Expr::Kind::asin, {(y - a.cy) / a.r});
      return std::cos(measured) >= 0 ? near(s) : near(Expr(pi) - s);
    };
    if (at_axis || (!b && o_.revolve)) {
      if (a.cx == Expr(0)) return near(Expr(std::sin(measured) >= 0 ? pi / 2 : -pi / 2));
      return crossing_x(Expr(0));
    }
    if (b && !b->curved() && b->way != Way::oblique) {
      const int axis = b->way == Way::vertical ? 0 : 1;
      const double side = (axis == 0 ? cx : cy) - levels_[b->level].value;
      if (tangent) return near(Expr(axis == 0 ? (side > 0 ? pi : 0.0) : (side > 0 ? -pi / 2 : pi / 2)));
      const double reach = std::abs(side) / r;
      if (reach < 1) return axis == 0 ? crossing_x(level_expr(b->level)) : crossing_y(level_expr(b->level));
    }
    // A free end: the neighbour starts where the arc stops.
    double angle = measured;
    if (b && b->s.arc) {
      // Two arcs with a corner between them: where their circles cross.
      const Expr dx = b->cx - a.cx, dy = b->cy - a.cy;
      const double d = std::hypot(value(dx), value(dy)), r2 = value(b->r);
      if (d > 0 && std::abs(d * d + r * r - r2 * r2) < 2 * d * r) {
        const Expr apart = Expr::call(Expr::Kind::sqrt, {dx * dx + dy * dy});
        const Expr half =
            Expr::call(Expr::Kind::acos, {(dx * dx + dy * dy + a.r * a.r - b->r * b->r) / (Expr(2) * apart * a.r)});
        const Expr base = Expr::call(Expr::Kind::atan2, {dy, dx});
        const Expr p = near(base + half), q = near(base - half);
        const Expr& best = std::abs(value(p) - measured) < std::abs(value(q) - measured) ? p : q;
        if (std::abs(value(best) - measured) < 0.3) return best;
      }
    } else if (b && !b->s.spline) {
      // Cut with the oblique line.
      const Vec2 c(cx, cy);
      const double foot = b->s.direction.dot(c - b->s.point), off = std::abs(cross(b->s.direction, c - b->s.point));
      if (off < r) {
        const double half = std::sqrt(r * r - off * off);
        double best = 1e300;
        for (const double s : {foot - half, foot + half}) {
          const Vec2 q = b->s.point + s * b->s.direction - c;
          const double v = turned_near(std::atan2(q.y(), q.x()), measured);
          if (std::abs(v - measured) < std::abs(best - measured)) best = v;
        }
        if (std::abs(best - measured) < 0.5) angle = best;
      }
    }
    return parameter(angle, Quantity::angle, a.name + "_end_angle", "angle at which the " + a.name + " ends");
  }

  // ---- elements
  // -------------------------------------------------------------------------------------------------------

  /// Faces are named after their parameters once those have their names: of level 3 "#3", of the chamfer that is the
  /// second piece of the first loop "/0 1".
  std::string edge_role(const Piece& p) const {
    if (p.curved()) return "";
    if (!p.s.supported) return "unseen end";
    if (p.way == Way::oblique)
      for (std::size_t l = 0; l < pieces_.size(); ++l)
        if (&p >= pieces_[l].data() && &p < pieces_[l].data() + pieces_[l].size() &&
            is_chamfer(pieces_[l], static_cast<std::size_t>(&p - pieces_[l].data()), loops_[l].axis_to_axis))
          return "/" + std::to_string(l) + " " + std::to_string(&p - pieces_[l].data());
    if (!o_.revolve) {
      if (p.way == Way::horizontal) return p.s.direction.x() > 0 ? "front" : "back";
      if (p.way == Way::vertical) return p.s.direction.y() > 0 ? "right" : "left";
      return "slope";
    }
    if (p.way != Way::oblique) return "#" + std::to_string(p.level);
    return "cone";
  }

  void add_point(Loop& loop, Expr x, Expr y, const std::string& edge) {
    loop.elements.push_back(SketchPoint{std::move(x), std::move(y), edge});
  }

  void emit(std::vector<Piece>& pieces, const LoopPieces& source) {
    Loop loop;
    loop.name = source.name;
    const std::size_t n = pieces.size();
    if (source.axis_to_axis && !pieces.front().curved()) {
      const Piece& p = pieces.front();
      add_point(loop, Expr(0), axis_height(p), edge_role(p));
    }
    for (std::size_t i = 0; i < n; ++i) {
      Piece& p = pieces[i];
      if (p.s.arc) {
        const Piece* after = neighbour(pieces, i, +1, source.axis_to_axis);
        loop.elements.push_back(
            SketchArc{p.cx, p.cy, p.r, p.from, p.to, n == 1 ? source.name : p.name, after ? edge_role(*after) : ""});
        continue;
      }
      const Piece* after = neighbour(pieces, i, +1, source.axis_to_axis);
      if (p.s.spline) {
        const Piece* before = neighbour(pieces, i, -1, source.axis_to_axis);
        SketchNurbs spline;
        spline.degree = p.s.curve.t.degree;
        spline.knots = p.s.curve.t.knots;
        const double step = power_of_ten_below(o_.tolerance / 100);
        // Its ends lie on the edges beside it, or on the axis: the nodes stop a little short of them.
        std::vector<Vec2> control = p.s.curve.points;
        auto reach = [&](Vec2& end, const Vec2& inner, int axis, double to) {
          const Vec2 direction = end - inner;
          const double t = direction[axis] != 0 ? (to - end[axis]) / direction[axis] : 0;
          if (t > -1 && t < 2) end += t * direction;
          end[axis] = to;
        };
        auto attach = [&](Vec2& end, const Vec2& inner, const Piece* b) -> std::array<std::optional<Expr>, 2> {
          if (!b && source.axis_to_axis) {
            reach(end, inner, 0, 0);
            return {Expr(0), std::nullopt};
          }
          if (!b || b->curved() || b->way == Way::oblique) return {};
          const int axis = b->way == Way::vertical ? 0 : 1;
          reach(end, inner, axis, levels_[b->level].value);
          if (axis == 0) return {level_expr(b->level), std::nullopt};
          return {std::nullopt, level_expr(b->level)};
        };
        const auto first = attach(control.front(), control[1], before);
        const auto last = attach(control.back(), control[control.size() - 2], after);
        for (const auto& c : control)
          spline.control.push_back({Expr(snapped(c.x(), step)), Expr(snapped(c.y(), step))});
        for (int axis = 0; axis < 2; ++axis) {
          if (first[axis]) spline.control.front()[axis] = *first[axis];
          if (last[axis]) spline.control.back()[axis] = *last[axis];
        }
        spline.name = "curve";
        spline.edge = after ? edge_role(*after) : source.axis_to_axis ? "axis" : "";
        loop.elements.push_back(std::move(spline));
        continue;
      }
      if (!after) {
        if (source.axis_to_axis) add_point(loop, Expr(0), axis_height(p), "axis");
        continue;
      }
      if (after->curved()) continue;  // the curve's end is the corner
      corner(loop, pieces, i, p, *after, source.axis_to_axis);
    }
    if (source.axis_to_axis && pieces.back().s.arc) std::get<SketchArc>(loop.elements.back()).edge = "axis";
    result_.sketch.loops.push_back(std::move(loop));
  }

  /// Where a line from or to the axis meets it.
  Expr axis_height(const Piece& p) {
    if (p.way == Way::horizontal) return level_expr(p.level);
    const double y = p.s.point.y() -
                     (std::abs(p.s.direction.x()) > 1e-9 ? p.s.point.x() / p.s.direction.x() * p.s.direction.y() : 0);
    return coordinate(1, y, "tip_z", "height of the tip on the axis");
  }

  /// The two legs of a chamfer: along x and along y; equal legs are one parameter.
  std::pair<Expr, Expr> chamfer_legs(const std::vector<Piece>& pieces, std::size_t i, bool axis_to_axis) {
    if (const auto found = chamfers_.find(&pieces[i]); found != chamfers_.end()) return found->second;
    const Piece& p = pieces[i];
    const Piece* before = neighbour(pieces, i, -1, axis_to_axis);
    const Piece* after = neighbour(pieces, i, +1, axis_to_axis);
    const Piece& h = before->way == Way::horizontal ? *before : *after;
    const Piece& v = before->way == Way::horizontal ? *after : *before;
    ProfileSegment hl = h.s, vl = v.s;
    hl.direction = {1, 0}, vl.direction = {0, 1};
    const auto on_h = crossing_of(p.s, hl), on_v = crossing_of(p.s, vl);
    const double dx = on_h ? std::abs(on_h->x() - v.s.point.x()) : p.s.length();
    const double dy = on_v ? std::abs(on_v->y() - h.s.point.y()) : p.s.length();
    std::pair<Expr, Expr> legs;
    if (std::abs(dx - dy) < o_.tolerance / 2) {
      for (const auto& known : chamfer_sizes_)
        if (std::abs(known.first - 0.5 * (dx + dy)) < same_ * 2) legs = {known.second, known.second};
      if (legs.first == Expr()) {
        const Expr c =
            parameter(0.5 * (dx + dy), Quantity::length, "chamfer", "width and height of the 45 degree chamfer");
        chamfer_sizes_.emplace_back(0.5 * (dx + dy), c);
        legs = {c, c};
      }
    } else {
      const char* second = o_.revolve ? "height" : "depth";
      legs = {
          parameter(dx, Quantity::length, "taper_width", "width of the sloped edge"),
          parameter(dy, Quantity::length, std::string("taper_") + second, std::string(second) + " of the sloped edge")};
    }
    return chamfers_[&pieces[i]] = legs;
  }

  void corner(Loop& loop, const std::vector<Piece>& pieces, std::size_t i, const Piece& a, const Piece& b,
              bool axis_to_axis) {
    const std::string edge = edge_role(b);
    const std::size_t next = (i + 1) % pieces.size();
    auto x_of = [&](const Piece& p) {
      return p.way == Way::vertical ? std::optional<Expr>(level_expr(p.level)) : std::nullopt;
    };
    auto y_of = [&](const Piece& p) {
      return p.way == Way::horizontal ? std::optional<Expr>(level_expr(p.level)) : std::nullopt;
    };
    std::optional<Expr> x = x_of(a) ? x_of(a) : x_of(b), y = y_of(a) ? y_of(a) : y_of(b);
    const Vec2 joint = crossing_of(a.s, b.s).value_or(0.5 * (a.s.end + b.s.start));
    const Vec2 safe = (joint - 0.5 * (a.s.end + b.s.start)).norm() < a.s.length() + b.s.length()
                          ? joint
                          : Vec2(0.5 * (a.s.end + b.s.start));
    // Parallel neighbours leave a small step between two levels.
    if (a.way == b.way && a.way != Way::oblique && a.level == b.level) return;  // one edge in two pieces
    if (x_of(a) && x_of(b)) {
      const Expr step = coordinate(1, safe.y(), o_.revolve ? "step_z" : "step_y", "position of a step");
      if (!(*x_of(a) == *x_of(b))) add_point(loop, *x_of(a), step, "step");
      add_point(loop, *x_of(b), step, edge);
      return;
    }
    if (y_of(a) && y_of(b)) {
      const Expr step = coordinate(0, safe.x(), o_.revolve ? "step_r" : "step_x", "position of a step");
      if (!(*y_of(a) == *y_of(b))) add_point(loop, step, *y_of(a), "step");
      add_point(loop, step, *y_of(b), edge);
      return;
    }
    for (const auto& [line, chamfered] : {std::pair{&a, i}, {&b, next}}) {
      if (!is_chamfer(pieces, chamfered, axis_to_axis)) continue;
      (void)line;
      const auto [dx, dy] = chamfer_legs(pieces, chamfered, axis_to_axis);
      const Piece& c = pieces[chamfered];
      const Piece* before = neighbour(pieces, chamfered, -1, axis_to_axis);
      const Piece* after = neighbour(pieces, chamfered, +1, axis_to_axis);
      const Piece& h = before->way == Way::horizontal ? *before : *after;
      const Piece& v = before->way == Way::horizontal ? *after : *before;
      const Vec2 middle = 0.5 * (c.s.start + c.s.end);
      if (y) {
        const Expr wall = level_expr(v.level);
        x = middle.x() < v.s.point.x() ? wall - dx : wall + dx;
      } else {
        const Expr face = level_expr(h.level);
        y = middle.y() < h.s.point.y() ? face - dy : face + dy;
      }
      break;
    }
    if (!x)
      x = coordinate(0, safe.x(), o_.revolve ? "corner_r" : "corner_x",
                     o_.revolve ? "distance of a corner from the axis" : "x of a corner");
    if (!y)
      y = coordinate(1, safe.y(), o_.revolve ? "corner_z" : "corner_y",
                     o_.revolve ? "height of a corner" : "y of a corner");
    add_point(loop, *x, *y, edge);
  }

  /// Edges of chamfers, found under "/0 1", are told by the parameter that their legs got: "/#7".
  void tell_chamfers() {
    const auto told = [&](std::string& edge) {
      if (!edge.starts_with('/')) return;
      const std::size_t space = edge.find(' ');
      const auto found =
          chamfers_.find(&pieces_[std::stoul(edge.substr(1, space - 1))][std::stoul(edge.substr(space + 1))]);
      edge = found != chamfers_.end() ? "/" + found->second.first.parameter : o_.revolve ? "cone" : "slope";
    };
    for (auto& loop : result_.sketch.loops)
      for (auto& element : loop.elements) std::visit([&](auto& e) { told(e.edge); }, element);
  }

  std::vector<LoopPieces> loops_;
  SketchOptions o_;
  double same_;
  Vec2 origin_ = Vec2::Zero();
  SketchNumbers numbers_;
  BuiltSketch result_;
  std::vector<std::vector<Piece>> pieces_;
  std::vector<Level> levels_;
  SketchNumbers::Shared radii_;
  std::map<std::pair<int, int>, std::pair<Expr, Expr>> half_widths_;  // radius and centre between two levels
  std::map<const Piece*, std::pair<Expr, Expr>> chamfers_;
  std::vector<std::pair<double, Expr>> chamfer_sizes_;
};

}  // namespace

BuiltSketch build_sketch(std::vector<LoopPieces> loops, const SketchOptions& options) {
  return Builder(std::move(loops), options).build();
}

}  // namespace partscribe::fit
