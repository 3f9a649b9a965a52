/// Integration: overlapping views become one nonredundant cloud, and every merged point knows its samples.
#pragma once

#include <cstdint>
#include <vector>

#include "core/context.h"
#include "geometry/points/point_cloud.h"

namespace partscribe::scan {

struct MergeOptions {
  double spacing = 0;               ///< mm between merged points; larger is coarser; 0: as dense as the views are
  double max_normal_angle = 0.436;  ///< rad; samples whose normals differ by more are never averaged
  double max_sigmas = 3;            ///< samples farther apart along the normal are another surface, or wrong
};

struct MergedCloud {
  PointCloud cloud;    ///< with normals, sigma, and the ray, view and pixel of each point's best sample
  double spacing = 0;  ///< mm
  /// Samples of merged point i: sample[first[i]] ... sample[first[i + 1] - 1], indices into the source.
  std::vector<std::uint32_t> first, sample;
};

/// Keeps, at every place, the sample of smallest sigma (Poisson disks of `spacing`, apart for normals that differ by
/// more than 60 degrees, so that edges and both sides of thin walls stay) and moves it along its own normal to the mean
/// of the views around it, each weighted by its variance: what is next to an edge keeps its place. Samples of one view
/// count as one, for a filter has made them alike. A sample of which no two others around say that a surface passes
/// there, of its own view or another, is left out. `cloud` needs normals, sigma and view; rejected points are left out.
/// Where the normal is unknown (zero) a sample stands for itself. The same for any number of threads.
MergedCloud merge_views(const PointCloud& cloud, const MergeOptions& options, Context& context);

}  // namespace partscribe::scan
