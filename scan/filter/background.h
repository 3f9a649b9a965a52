/// A part on its table, cut out of everything else that a sensor saw.
#pragma once

#include <cstdint>
#include <vector>

#include "core/result.h"
#include "geometry/points/point_cloud.h"

namespace partscribe::scan {

/// What stands on the largest plane.
struct Foreground {
  std::vector<std::uint8_t> keep;  ///< one per point, 1: of the thing asked for
  Vec3 normal = Vec3::UnitZ();     ///< of the plane, towards the things
  double offset = 0;               ///< normal . p on the plane, mm
  double lost = 0;                 ///< mm above the plane that went with it, because noise hides what they are
  std::size_t support = 0;         ///< points on the plane
  std::size_t above = 0;           ///< points over it, within its outline
  std::size_t behind = 0;  ///< points under it: outliers beside a table, most of a body where the plane is a step of it
  /// points on it with as many others straight over them: a table is hidden there, a body's lowest face is not
  std::size_t covered = 0;
  std::vector<std::size_t> things;  ///< points of each, the largest first
};

/// Finds the plane that most points lie on (random samples, then least squares), its largest connected piece, and the
/// connected pieces above that piece's convex hull; `which` of them (1: the one of most points) is kept. The cloud must
/// have normals; `sigma` and `spacing` in mm. Fails when there is no such plane or no such thing.
Result<Foreground> cut_background(const PointCloud& cloud, double sigma, double spacing, int which);

}  // namespace partscribe::scan
