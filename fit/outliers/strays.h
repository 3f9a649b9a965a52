/// Tells the points of surfaces from strays: clusters, curtains behind edges, points strewn through space.
#pragma once

#include <cstdint>
#include <vector>

#include "core/context.h"
#include "geometry/vec.h"

namespace partscribe::fit {

/// What the neighbourhoods of a cloud say of its points.
struct SurfacePoints {
  std::vector<std::uint8_t>
      stray;                  ///< 1: no plane through the point holds most of its neighbours, nor do theirs hold it
  std::vector<Vec3> normals;  ///< unit, any sign; of the local plane, from points on it alone
  std::vector<float> share;   ///< of the neighbours, on the local plane; 0 for what is no wider than thick
  double sigma = 0;           ///< mm, noise along the normals
  std::size_t strays = 0;
};

/// `sigma`: a first guess of the noise, mm. Neighbourhoods are at least ten sigmas wide, so that a surface can be told
/// from a cloud; where points are dense a selection of them, spread that far, speaks for all. Planes through each point
/// are drawn from pairs of neighbours; a point belongs to a surface if three neighbours, whose own planes hold most of
/// theirs, hold it. Neighbours that were seen from behind the plane are the far side of a thin wall and do not count.
/// Repeated without the strays until nothing changes, the noise included, of which the guess may be several times too
/// wide. Strays too are curtains: planes along the viewing rays (`rays`: of each point, or none), and, where a tenth of
/// the points are strays or strewn so thinly that most have no clear plane, what is a tenth as dense as the middle of
/// the surface; and pieces that hang together but hold less than 3 % of the points. The same for any number of threads.
SurfacePoints surface_points_of(const std::vector<Vec3>& points, const std::vector<Vec3>& rays, double sigma,
                                Context& context);

}  // namespace partscribe::fit
