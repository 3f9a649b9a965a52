/// Other programs' integration of views, for the benchmark.
#pragma once

#include <string>
#include <vector>

#include "geometry/vec.h"

namespace peers {

/// A filtered view behind a pinhole: x = (column - cx) / fx * depth, y alike.
struct DepthView {
  int width = 0, height = 0;
  double fx = 1, fy = 1, cx = 0, cy = 0;
  partscribe::geometry::Pose world_from_view;
  std::vector<float> depth;  ///< mm, row by row; 0: none
};

/// False when the benchmark was built without it; the others then give nothing.
bool has_open3d();
/// Where the truncated signed distance field is zero on the edges of its grid; truncated at four voxels.
std::vector<partscribe::geometry::Vec3> open3d_distance_field(const std::vector<DepthView>& views, double voxel,
                                                              bool scalable);
/// Vertices of the screened Poisson surface with an octree of this depth, but for the hundredth with least support.
std::vector<partscribe::geometry::Vec3> open3d_poisson(const std::vector<partscribe::geometry::Vec3>& points,
                                                       const std::vector<partscribe::geometry::Vec3>& normals,
                                                       int depth);

}  // namespace peers
