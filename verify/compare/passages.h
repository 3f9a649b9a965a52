/// Scanned points whose rays run through the evaluated surface: what would hide a point that was seen is not there.
#pragma once

#include <cstdint>
#include <vector>

#include "verify/compare/data_to_model.h"
#include "verify/compare/outliers.h"

namespace partscribe::verify {

/// Where rays enter the evaluated surface more than the tolerance before they reach their point. Rays that pass its
/// outline by less than the tolerance or a pixel are left out: an edge may be so far off, and mixed pixels and small
/// errors of the poses end behind it.
struct Passages {
  std::vector<Vec3> places;  ///< on the surface
  std::vector<std::uint32_t> triangles;
  std::vector<OutlierCluster> clusters;  ///< of places, where they are more than outliers behind the surface explain
};

/// Only views whose sensor is known count; without one there are no passages. `false_alarm`: the chance of any cluster
/// on a true model.
Passages passages_through(const ScanSource& source, const PointField& points, const MeshDistance& surface,
                          const std::vector<Vec3>& normals, double tolerance, double false_alarm, int threads);

}  // namespace partscribe::verify
