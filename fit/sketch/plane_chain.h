/// Puts scattered points of plane curves into order: chains of averaged nodes along each curve.
#pragma once

#include <optional>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::fit {

/// A point of a plane figure's boundary.
struct PlanePoint {
  Vec2 position;
  Vec2 normal;  ///< unit, of unknown sign
};

/// Where the normals of two points meet: the centre of a circle that holds both, if their distances from it agree.
struct NormalsMeeting {
  Vec2 place;
  double from_a = 0, from_b = 0;  ///< mm
};

/// Nothing if the sine of the angle between the normals is below `least_sine`.
std::optional<NormalsMeeting> where_normals_meet(const PlanePoint& a, const PlanePoint& b, double least_sine);

/// The mean of many points.
struct ChainNode {
  Vec2 position;
  Vec2 tangent;         ///< unit, of unknown sign
  double sigma = 0;     ///< mm, of the position across the curve
  double weight = 0;    ///< points
  bool corner = false;  ///< its points do not agree on a direction
};

struct Chain {
  std::vector<ChainNode> nodes;
  bool closed = false;
  std::vector<double> gaps;  ///< lengths (mm) of jumps over missing data that were bridged
};

struct ChainOptions {
  double cell = 0;        ///< mm between nodes
  double noise = 0;       ///< mm, of one point
  double axis = -1;       ///< >= 0: ends within this of x = 0 end on the axis and are not joined to others
  std::size_t least = 3;  ///< nodes; chains of fewer are outliers
};

/// Chains by decreasing length. Ends that face each other over missing data are joined, nearest first.
std::vector<Chain> chains_of(const std::vector<PlanePoint>& points, const ChainOptions& options);

double length_of(const Chain& chain);

/// Whether the nodes, `cell` mm apart, lie beside each other as in an area, and not along a curve or two.
bool fills_area(const Chain& chain, double cell);

/// The points moved onto the middle of the band that noise made of their curve, along the mean normal of those within
/// `reach` mm that face the same way; isolated points, with less than the share `alone` of the usual number of
/// neighbours, are left out. Corners stay: the two sides of one face different ways.
std::vector<PlanePoint> sharpened(std::vector<PlanePoint> points, double reach, double alone = 0.05);

}  // namespace partscribe::fit
