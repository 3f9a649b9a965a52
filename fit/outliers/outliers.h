/// Tells the points of surfaces from outliers: clusters, curtains behind edges, points scattered through space.
#pragma once

#include <cstdint>
#include <vector>

#include "core/context.h"
#include "geometry/vec.h"

namespace partscribe::fit {

/// What is known about each point of a cloud from its neighbourhood.
struct SurfacePoints {
  /// 1: no plane through the point holds most of its neighbours, nor do theirs hold it
  std::vector<std::uint8_t> outlier;
  std::vector<Vec3> normals;  ///< unit, any sign; of the local plane, from points on it alone
  std::vector<float> share;   ///< of the neighbours, on the local plane; 0 for what is no wider than thick
  double sigma = 0;           ///< mm, noise along the normals
  std::size_t outliers = 0;
};

/// A point belongs to a surface if it lies on the local planes of three neighbours, each of which contains most of that
/// neighbour's own neighbours. Candidates for the plane through a point are drawn from pairs of its neighbours.
/// Neighbourhoods are at least ten sigmas wide (`sigma`: a first guess of the noise, mm), so that a surface can be told
/// from a volume filled with points; where points are dense, a sample of them that is spread over this width is used.
/// Neighbours that were seen from behind the plane are on the far side of a thin wall and do not count. All this is
/// repeated without the outliers found, and with a new estimate of the noise because the first guess may be several
/// times too large, until nothing changes.
///
/// Also outliers are
/// - curtains, that is planes along the viewing rays (`rays`: one per point, or none);
/// - connected pieces of less than 3 % of the points;
/// - points a tenth as dense as the median of the surface, if a tenth of all points are outliers, or are so sparse that
///   most of them have no clear plane.
/// The result does not depend on the number of threads.
SurfacePoints surface_points_of(const std::vector<Vec3>& points, const std::vector<Vec3>& rays, double sigma,
                                Context& context);

}  // namespace partscribe::fit
