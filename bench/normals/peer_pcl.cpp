// PCL: NormalEstimationOMP with one thread, and integral images for grids. Its points are floats.
#include "peers.h"

#ifdef PARTSCRIBE_HAS_PCL
#include <pcl/features/integral_image_normal.h>
#include <pcl/features/normal_3d_omp.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

namespace peers {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Normals = pcl::PointCloud<pcl::Normal>;

Cloud::Ptr cloud_of(const std::vector<Vec3>& points) {
  Cloud::Ptr cloud(new Cloud);
  cloud->reserve(points.size());
  for (const Vec3& p : points) cloud->push_back(pcl::PointXYZ(float(p.x()), float(p.y()), float(p.z())));
  return cloud;
}

std::vector<Vec3> vectors_of(const Normals& normals) {
  std::vector<Vec3> result;
  result.reserve(normals.size());
  for (const pcl::Normal& n : normals) result.emplace_back(n.normal_x, n.normal_y, n.normal_z);
  return result;
}

std::vector<Vec3> planes(const std::vector<Vec3>& points, int count) {
  pcl::NormalEstimationOMP<pcl::PointXYZ, pcl::Normal> estimation(1);
  estimation.setInputCloud(cloud_of(points));
  estimation.setSearchMethod(pcl::search::KdTree<pcl::PointXYZ>::Ptr(new pcl::search::KdTree<pcl::PointXYZ>(false)));
  estimation.setKSearch(count);
  Normals normals;
  estimation.compute(normals);
  return vectors_of(normals);
}

/// `change`: the step between pixels, in thousandths of the depth, beyond which windows end; its authors use 20.
template <int method, int change>
std::vector<Vec3> grid(const std::vector<Vec3>& points, int width, int height) {
  using Estimation = pcl::IntegralImageNormalEstimation<pcl::PointXYZ, pcl::Normal>;
  Cloud::Ptr cloud = cloud_of(points);
  cloud->width = unsigned(width), cloud->height = unsigned(height), cloud->is_dense = false;
  Estimation estimation;
  estimation.setNormalEstimationMethod(method == 0 ? Estimation::COVARIANCE_MATRIX : Estimation::AVERAGE_3D_GRADIENT);
  estimation.setNormalSmoothingSize(5.0f);
  estimation.setMaxDepthChangeFactor(0.001f * change);
  estimation.setInputCloud(cloud);
  Normals normals;
  estimation.compute(normals);
  return vectors_of(normals);
}

}  // namespace

std::vector<CloudMethod> pcl_methods() { return {{"PCL", &planes}}; }
std::vector<GridMethod> pcl_grid_methods() {
  return {{"PCL integral images, covariance", &grid<0, 20>},
          {"PCL integral images, gradient", &grid<1, 20>},
          {"PCL integral images, gradient, steps 2", &grid<1, 2>}};
}

}  // namespace peers
#else
namespace peers {
std::vector<CloudMethod> pcl_methods() { return {}; }
std::vector<GridMethod> pcl_grid_methods() { return {}; }
}  // namespace peers
#endif
