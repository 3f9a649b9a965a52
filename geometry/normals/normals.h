/// Robust normals, local noise and outlier flags of a cloud whose sampling is not known beforehand.
#pragma once

#include "core/context.h"
#include "geometry/points/point_cloud.h"

namespace partscribe::geometry {

struct NormalOptions {
  int neighbours = 30;        ///< more smooths noise and blurs edges
  int rounds = 4;             ///< of reweighting; each sharpens edges
  double outlier_sigmas = 5;  ///< points farther than this from their neighbours' plane are rejected
};

/// What estimate_normals learned of the whole cloud.
struct SamplingSummary {
  double spacing = 0;  ///< median distance to the nearest neighbour, mm
  double sigma = 0;    ///< median noise along the normal, mm
  std::size_t rejected = 0;
};

/// Fills cloud.normals (unit; turned against the rays where there are any), cloud.sigma (all equal to the
/// summary's sigma unless known already) and cloud.rejected. Weighted PCA: `reference`: weights
/// exp(-d^2/18 s^2) max(0, n.n_j)^4 in a radius fixed from noise and spacing. Normals that a round turned by less than
/// the noise turns them take no part in the rounds that follow.
SamplingSummary estimate_normals(PointCloud& cloud, const NormalOptions& options, Context& context);

}  // namespace partscribe::geometry
