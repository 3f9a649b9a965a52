// Open3D: its kd-tree (nanoflann) and covariance matrices, its fast eigenvectors.
#include "peers.h"

#ifdef PARTSCRIBE_HAS_OPEN3D
#include <open3d/geometry/PointCloud.h>

namespace peers {
namespace {

std::vector<Vec3> planes(const std::vector<Vec3>& points, int count) {
  open3d::geometry::PointCloud cloud(points);
  cloud.EstimateNormals(open3d::geometry::KDTreeSearchParamKNN(count));
  return cloud.normals_;
}

}  // namespace

std::vector<CloudMethod> open3d_methods() { return {{"Open3D", &planes}}; }

}  // namespace peers
#else
namespace peers {
std::vector<CloudMethod> open3d_methods() { return {}; }
}  // namespace peers
#endif
