// small_gicp: its kd-tree and its normals, one thread.
#include "peers.h"

#if __has_include(<small_gicp/util/normal_estimation.hpp>)
#include <small_gicp/ann/kdtree.hpp>
#include <small_gicp/points/point_cloud.hpp>
#include <small_gicp/util/normal_estimation.hpp>

namespace peers {
namespace {

std::vector<Vec3> planes(const std::vector<Vec3>& points, int count) {
  small_gicp::PointCloud cloud(points);
  small_gicp::KdTree<small_gicp::PointCloud> tree(std::make_shared<small_gicp::PointCloud>(cloud));
  small_gicp::estimate_normals(cloud, tree, count);
  std::vector<Vec3> result;
  for (std::size_t i = 0; i < cloud.size(); ++i) result.push_back(cloud.normal(i).head<3>());
  return result;
}

}  // namespace

std::vector<CloudMethod> small_gicp_methods() { return {{"small_gicp", &planes}}; }

}  // namespace peers
#else
namespace peers {
std::vector<CloudMethod> small_gicp_methods() { return {}; }
}  // namespace peers
#endif
