/// Poses of one view against another from nothing but their shapes.
#pragma once

#include <vector>

#include "scan/register/register_pair.h"

namespace partscribe::scan {

/// Oriented points of a view with a histogram of the normals around each (33 numbers; Rusu 2009).
struct Features {
  Surfels surfels;
  std::vector<Eigen::Matrix<float, 33, 1>> histograms;
  std::unique_ptr<KdTree> tree;  ///< over surfels.points
  double cell = 0;               ///< mm between surfels
};

/// `cell` must be the same for all views that are compared.
std::unique_ptr<Features> features_of(const ViewSurface& surface, double cell);

/// Candidates for target_from_source, the best first, from pairs of points with like histograms, distances and angles.
std::vector<Pose> feature_poses(const Features& source, const Features& target, std::size_t most);

}  // namespace partscribe::scan
