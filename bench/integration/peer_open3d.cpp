// Open3D: its distance fields and its screened Poisson surface, one thread where it can be asked for.
#include "bench/integration/peers.h"

#ifdef PARTSCRIBE_HAS_OPEN3D
#include <open3d/camera/PinholeCameraIntrinsic.h>
#include <open3d/geometry/Image.h>
#include <open3d/geometry/PointCloud.h>
#include <open3d/geometry/RGBDImage.h>
#include <open3d/geometry/TriangleMesh.h>
#include <open3d/pipelines/integration/ScalableTSDFVolume.h>
#include <open3d/pipelines/integration/UniformTSDFVolume.h>

#include <algorithm>
#include <cstring>

namespace peers {

using partscribe::geometry::Vec3;
namespace o3d = open3d::pipelines::integration;

bool has_open3d() { return true; }

std::vector<Vec3> open3d_distance_field(const std::vector<DepthView>& views, double voxel, bool scalable) {
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const DepthView& view : views)
    for (std::size_t i = 0; i < view.depth.size(); ++i) {
      const double z = view.depth[i];
      if (z <= 0) continue;
      const Vec3 p = view.world_from_view * Vec3((double(i % std::size_t(view.width)) - view.cx) / view.fx * z,
                                                 (double(i / std::size_t(view.width)) - view.cy) / view.fy * z, z);
      low = low.cwiseMin(p), high = high.cwiseMax(p);
    }
  const double length = (high - low).maxCoeff() + 8 * voxel;
  const int resolution = int(length / voxel) + 1;
  std::unique_ptr<o3d::TSDFVolume> volume;
  if (scalable)
    volume = std::make_unique<o3d::ScalableTSDFVolume>(voxel, 4 * voxel, o3d::TSDFVolumeColorType::NoColor);
  else
    volume = std::make_unique<o3d::UniformTSDFVolume>(
        resolution * voxel, resolution, 4 * voxel, o3d::TSDFVolumeColorType::NoColor, low - Vec3::Constant(4 * voxel));
  for (const DepthView& view : views) {
    open3d::geometry::RGBDImage image;
    image.depth_.Prepare(view.width, view.height, 1, 4);
    std::memcpy(image.depth_.data_.data(), view.depth.data(), view.depth.size() * 4);
    image.color_.Prepare(view.width, view.height, 3, 1);
    const partscribe::geometry::Pose view_from_world = view.world_from_view.inverse();
    Eigen::Matrix4d extrinsic = Eigen::Matrix4d::Identity();
    extrinsic.topLeftCorner<3, 3>() = view_from_world.rotation,
                               extrinsic.topRightCorner<3, 1>() = view_from_world.translation;
    volume->Integrate(
        image, open3d::camera::PinholeCameraIntrinsic(view.width, view.height, view.fx, view.fy, view.cx, view.cy),
        extrinsic);
  }
  return volume->ExtractPointCloud()->points_;
}

std::vector<Vec3> open3d_poisson(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, int depth) {
  open3d::geometry::PointCloud cloud(points);
  cloud.normals_ = normals;
  const auto [mesh, support] =
      open3d::geometry::TriangleMesh::CreateFromPointCloudPoisson(cloud, std::size_t(depth), 0.0f, 1.1f, false, 1);
  std::vector<double> sorted = support;
  const auto hundredth = sorted.begin() + std::ptrdiff_t(sorted.size() / 100);
  std::nth_element(sorted.begin(), hundredth, sorted.end());
  std::vector<Vec3> result;
  for (std::size_t i = 0; i < mesh->vertices_.size(); ++i)
    if (support[i] >= *hundredth) result.push_back(mesh->vertices_[i]);
  return result;
}

}  // namespace peers

#else

namespace peers {

bool has_open3d() { return false; }
std::vector<partscribe::geometry::Vec3> open3d_distance_field(const std::vector<DepthView>&, double, bool) {
  return {};
}
std::vector<partscribe::geometry::Vec3> open3d_poisson(const std::vector<partscribe::geometry::Vec3>&,
                                                       const std::vector<partscribe::geometry::Vec3>&, int) {
  return {};
}

}  // namespace peers

#endif
