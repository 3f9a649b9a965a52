/// Gives the normals of a closed cloud one sense, outward, where no rays tell it.
#pragma once

#include "core/context.h"
#include "geometry/points/point_cloud.h"

namespace partscribe::geometry {

/// The sign of the normals is propagated along a minimum spanning tree over the nearest neighbours, first where normals
/// agree best [Hoppe et al. 1992]. The outside of a connected piece is the side from which more straight lines lead
/// past all points [Takayama et al. 2014]; if neither side is more open, its outermost points decide. Where two faces
/// meet at an edge and each is open enough to determine its own outside, neither is flipped to agree with the other.
///
/// Of 128 lines each point sends out one in `turns`, its neighbours the others: whole faces need no more, walls of deep
/// slots may.
///
/// Rejected points and zero normals stay as they are. Does not depend on the order of the points. Returns the number of
/// connected pieces.
std::size_t orient_normals(PointCloud& cloud, int neighbours, Context& context, int turns = 1);

}  // namespace partscribe::geometry
