/// Other programs' registration of one pair of views, for the benchmark.
#pragma once

#include <string>
#include <vector>

#include "geometry/vec.h"

namespace peers {

/// One method with one setting. It aligns `second` (from its guess) to `first`, both in the frames of their views, and
/// returns the pose of the second in the frame of the first, where `guess` is as well. Lengths in mm.
struct Method {
  std::string name;
  double gate = 0;  ///< largest distance of partners, share of the part's radius
  partscribe::geometry::Pose (*align)(const std::vector<partscribe::geometry::Vec3>& first,
                                      const std::vector<partscribe::geometry::Vec3>& second,
                                      const partscribe::geometry::Pose& guess, double spacing, double gate);
};

/// Empty when the benchmark was built without the peer.
std::vector<Method> small_gicp_methods();
std::vector<Method> pcl_methods();
std::vector<Method> open3d_methods();

}  // namespace peers
