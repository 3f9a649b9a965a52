/// Tells the points of surfaces from outliers: clusters, curtains behind edges, points strewn through space.
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

/// `sigma`: a first guess of the noise, mm. Neighbourhoods are at least ten sigmas wide, so that a surface can be told
/// from a cloud; where points are dense a sample of them, spread over that width, stands for all. Planes through each
/// point are drawn from pairs of neighbours. A point belongs to a surface if it lies on the planes of three neighbours,
/// each of which contains most of that neighbour's own neighbours. Neighbours that were seen from behind the plane are
/// the far side of a thin wall and do not count. Repeated without the outliers until nothing changes, and with a new
/// estimate of the noise, because the guess may be several times too large. Also outliers are: curtains, that is planes
/// along the viewing rays (`rays`: of each point, or none); if a tenth of the points are outliers or so sparse that
/// most have no clear plane, points a tenth as dense as the median of the surface; and connected pieces of less than 3
/// % of the points. The same for any number of threads.
SurfacePoints surface_points_of(const std::vector<Vec3>& points, const std::vector<Vec3>& rays, double sigma,
                                Context& context);

}  // namespace partscribe::fit
