/// Other programs' normals of clouds, and of organised clouds, for the benchmark.
#pragma once

#include <string>
#include <vector>

#include "geometry/vec.h"

namespace peers {

using partscribe::geometry::Vec3;

/// Normals by planes through the `count` nearest points, the point itself among them; of either sign, one thread.
struct CloudMethod {
  std::string name;
  std::vector<Vec3> (*normals)(const std::vector<Vec3>& points, int count);
};

/// Normals of a grid of points, row by row; not finite: no return, and no normal.
struct GridMethod {
  std::string name;
  std::vector<Vec3> (*normals)(const std::vector<Vec3>& points, int width, int height);
};

/// Empty where the peer was not found when the benchmark was built.
std::vector<CloudMethod> nanoflann_methods();
std::vector<CloudMethod> small_gicp_methods();
std::vector<CloudMethod> open3d_methods();
std::vector<CloudMethod> pcl_methods();
std::vector<CloudMethod> cgal_methods();
std::vector<GridMethod> pcl_grid_methods();

}  // namespace peers
