/// Gives the normals of a closed cloud one sense, outward, where no rays tell it.
#pragma once

#include "core/context.h"
#include "geometry/point_cloud.h"

namespace partscribe {

/// Carries the sense along a minimum spanning tree over the nearest neighbours, from where normals agree best [Hoppe et
/// al. 1992]; the outermost point of every connected piece says which side is out. Rejected points and zero normals
/// stay as they are. Does not depend on the order of the points. Returns the number of connected pieces.
std::size_t orient_normals(PointCloud& cloud, int neighbours, Context& context);

}  // namespace partscribe
