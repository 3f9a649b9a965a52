/// The pieces of a sketch before they have names: where their origin is, which way they run, which of them touch.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "fit/sketch/sketch_builder.h"

namespace partscribe::fit {

enum class Way { horizontal, vertical, oblique };

/// A piece of a profile on its way to become an element of a sketch.
struct SketchPiece {
  ProfileSegment s;        ///< from the sketch's origin
  Way way = Way::oblique;  ///< of a line
  int level = -1;          ///< of a horizontal or vertical line
  // Of an arc, once its relations are known:
  Expr cx, cy, r, from, to;
  double from0 = 0, to0 = 0;                        ///< measured, rad
  bool tangent_start = false, tangent_end = false;  ///< to a horizontal or vertical line
  bool solved = false;
  std::optional<Expr> joint_start, joint_end;  ///< angles fixed by a tangent neighbouring arc
  std::string name;

  bool curved() const { return s.arc || s.spline; }
};

/// A coordinate that horizontal or vertical edges share.
struct SketchLevel {
  int axis;  // 0: x (vertical lines), 1: y
  double value;
  double length = 0;
  double low = 1e300, high = -1e300;  // extent along the line
  bool rising = true;                 // direction of its longest line
  Expr expr;
  bool set = false;
};

/// Gives every straight piece along a coordinate direction its level; levels nearer than `same` mm are one.
void find_levels(std::vector<SketchPiece>& pieces, std::vector<SketchLevel>& levels, double same);

/// mm by which a relation may move the end of an edge.
double relation_slack(const SketchOptions& options);

/// Where a sketch has its origin, in the coordinates of the pieces.
struct SketchOrigin {
  Vec2 place = Vec2::Zero();
  std::array<bool, 2> middle = {false, false};  ///< along x and y: half way between the outline's outer edges
};

/// Revolve: the lowest flat face on the axis, else the centre of an arc on it, else the lowest point. Extrude: the
/// centre of a round outline; else along each axis the middle between the outer edges, if all holes lie evenly about
/// it, or the lower edge; where no straight edge bounds the outline, the centre of the largest round hole.
SketchOrigin sketch_origin(const std::vector<LoopPieces>& loops, const SketchOptions& options);

/// The loop's pieces from `origin`; straight ones that run along a coordinate direction are marked so.
std::vector<SketchPiece> sketch_pieces(const LoopPieces& loop, const Vec2& origin, const SketchOptions& options);

/// Is the arc centred on the axis of a revolve?
bool centred_on_axis(const SketchPiece& arc, const SketchOptions& options);

/// Does the arc end at `end_angle` where it touches the straight edge?
bool touches(const SketchPiece& arc, double end_angle, const SketchPiece& edge, const SketchOptions& options);

/// Do two arcs in a row meet without a corner?
bool arcs_tangent(const SketchPiece& first, const SketchPiece& second, const SketchOptions& options);

/// The piece before (step -1) or after (+1) one of a loop; null where there is none. `axis_to_axis`: the loop is open.
const SketchPiece* neighbour(const std::vector<SketchPiece>& pieces, std::size_t i, int step, bool axis_to_axis);

/// A short oblique edge between a horizontal and a vertical one.
bool is_chamfer(const std::vector<SketchPiece>& pieces, std::size_t i, bool axis_to_axis);

/// Where two lines cross, unless they are nearly parallel.
std::optional<Vec2> crossing_of(const ProfileSegment& a, const ProfileSegment& b);

/// The angle equal to `angle` up to full turns that is nearest to `near`.
double turned_near(double angle, double near);

double cross(const Vec2& a, const Vec2& b);

}  // namespace partscribe::fit
