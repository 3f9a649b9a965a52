/// Gives the normals of a closed cloud one sense, outward, where no rays tell it.
#pragma once

#include "core/context.h"
#include "geometry/points/point_cloud.h"

namespace partscribe::geometry {

/// Carries the sense along a minimum spanning tree over the nearest neighbours, from where normals agree best [Hoppe et
/// al. 1992]. Out is the side of a piece from which more straight lines lead past all points [Takayama et al. 2014],
/// and faces that tell by themselves are not turned by what meets them at an edge; where neither side is more open the
/// outermost points say it. Rejected points and zero normals stay as they are. Does not depend on the order of the
/// points. Returns the number of connected pieces.
std::size_t orient_normals(PointCloud& cloud, int neighbours, Context& context);

}  // namespace partscribe::geometry
