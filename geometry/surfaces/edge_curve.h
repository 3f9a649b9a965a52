/// Edges between trimmed surfaces as curves in space.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "geometry/surfaces/trimmed_surface.h"

namespace partscribe::geometry {

/// A surface and the piece of its border that an edge is there.
struct EdgeSide {
  const NurbsSurface* surface;
  const NurbsCurve<2>* trim;
};

/// The sides of all edges by their numbers; the first is the first that was met. The surfaces must outlive it.
std::map<int, std::vector<EdgeSide>> edge_sides(std::span<const TrimmedSurface> surfaces);

/// How far two sides of an edge are apart at equal shares, at `pieces` + 1 of them, mm; 0 for an edge of one side.
double edge_gap(std::span<const EdgeSide> sides, int pieces);

/// Where an edge is at a share (0 .. 1) of the domain of its first side's curve: the mean of its sides, the second of
/// which runs against the first. First derivative by the share as well; `below`: as seen from lower shares.
void edge_place(std::span<const EdgeSide> sides, double share, bool below, Vec3& place, Vec3& derivative);

/// The edge as a cubic over 0 .. 1 whose parameter is the share, with its derivatives at all knots: pieces are halved
/// until none is farther than `deviation` (mm) from equal shares of the edge.
NurbsCurve<3> edge_curve(std::span<const EdgeSide> sides, double deviation);

}  // namespace partscribe::geometry
