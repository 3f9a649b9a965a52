/// How noisy a cloud is along the normals of its surface, and how wide a neighbourhood must be to show that surface.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "geometry/points/kd_tree.h"
#include "geometry/points/point_cloud.h"

namespace partscribe::geometry {

struct LocalNoise {
  double sigma = 0;    ///< mm, median along the normal
  double pitch = 0;    ///< mm, of an even grid with as many points per area; 0: nothing was found
  bool dense = false;  ///< the nearest points are a ball of noise, and wider neighbourhoods show a surface

  /// The same as the flatter quarter of the neighbourhoods of one size have it, the smallest that are more than balls
  /// of noise: right also where walls and edges are so close that most wide neighbourhoods hold one. 0: there is no
  /// such size.
  double flat_sigma = 0, flat_pitch = 0;
};

/// Gives so many nearest neighbours of a point, itself among them, nearest first.
using NearestPoints = std::function<void(std::uint32_t point, std::size_t count, std::vector<Neighbour>& result)>;

/// From residuals of quadrics through the smallest neighbourhoods that are wider than the noise is thick, however many
/// points they hold. `points` in coordinate order, so that strides and ties do not depend on the order in a file.
LocalNoise local_noise(std::span<const Vec3> points, const NearestPoints& nearest, int threads);

/// The same sigma of the points that are not rejected; quick for millions of them.
double noise_along_normals(const PointCloud& cloud, int threads);

/// mm: what is narrower is a ball of noise, not a piece of surface, and its points err alike.
inline double thickness_of_noise(double sigma) { return 5 * sigma; }

}  // namespace partscribe::geometry
