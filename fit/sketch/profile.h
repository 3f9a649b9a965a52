/// Splits a chain of nodes into the fewest straight lines and circular arcs that explain it.
#pragma once

#include <vector>

#include "fit/sketch/plane_chain.h"
#include "geometry/surfaces/curve2.h"

namespace partscribe::fit {

/// One piece of a profile, in the direction of the chain: a line, an arc or a spline.
struct ProfileSegment {
  bool arc = false;
  bool spline = false;
  Vec2 start = Vec2::Zero(), end = Vec2::Zero();        ///< projections of the first and last node
  Vec2 point = Vec2::Zero(), direction = Vec2::Zero();  ///< of a line
  Vec2 center = Vec2::Zero();                           ///< of an arc
  double radius = 0;
  double sweep = 0;  ///< of an arc, rad, counter-clockwise positive
  Nurbs2 curve;      ///< of a spline: cubic, weights 1
  std::size_t nodes = 0;
  double points = 0;      ///< data behind it
  bool supported = true;  ///< false: bridges missing data
  double length() const;
};

struct ProfileOptions {
  double floor = 0.02;    ///< mm; deviations below this are not worth a segment
  double line_cost = 16;  ///< nats
  double arc_cost = 24;
  double size = 100;  ///< mm; arcs of more than four times this are lines
  double spline = 0;  ///< mm; above 0: four or more pieces in a row without a corner become one cubic
                      ///< spline that follows the nodes within this
};

/// Dynamic programming over all splits (prefix sums; line: smaller eigenvalue of the scatter, arc: Kasa's fit), then
/// an orthogonal refit of each piece without its outermost nodes. A closed chain is rotated to a break first.
std::vector<ProfileSegment> segments_of(const Chain& chain, const ProfileOptions& options);

}  // namespace partscribe::fit
