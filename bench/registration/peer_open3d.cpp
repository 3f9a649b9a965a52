// Open3D: GICP, and point to plane with Tukey's weights.
#include "peers.h"

#ifdef PARTSCRIBE_HAS_OPEN3D
#include <open3d/geometry/PointCloud.h>
#include <open3d/pipelines/registration/GeneralizedICP.h>
#include <open3d/pipelines/registration/Registration.h>
#include <open3d/pipelines/registration/RobustKernel.h>
#include <open3d/pipelines/registration/TransformationEstimation.h>

namespace peers {
namespace {

namespace o3d = open3d::pipelines::registration;
using open3d::geometry::KDTreeSearchParamKNN;
using partscribe::geometry::Pose;
using partscribe::geometry::Vec3;

std::shared_ptr<open3d::geometry::PointCloud> prepare(const std::vector<Vec3>& points, double voxel) {
  auto cloud = open3d::geometry::PointCloud(points).VoxelDownSample(voxel);
  cloud->EstimateNormals(KDTreeSearchParamKNN(10));
  cloud->OrientNormalsTowardsCameraLocation(Vec3(0, 0, -1e6));
  return cloud;
}

Eigen::Matrix4d matrix_of(const Pose& pose) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = pose.rotation, m.topRightCorner<3, 1>() = pose.translation;
  return m;
}

Pose pose_of(const Eigen::Matrix4d& m) { return {m.topLeftCorner<3, 3>(), m.topRightCorner<3, 1>()}; }

const o3d::ICPConvergenceCriteria end(1e-9, 1e-9, 100);

Pose gicp(const std::vector<Vec3>& first, const std::vector<Vec3>& second, const Pose& guess, double spacing,
          double gate) {
  auto target = prepare(first, 2 * spacing), source = prepare(second, 2 * spacing);
  target->EstimateCovariances(KDTreeSearchParamKNN(10)), source->EstimateCovariances(KDTreeSearchParamKNN(10));
  return pose_of(o3d::RegistrationGeneralizedICP(*source, *target, gate, matrix_of(guess),
                                                 o3d::TransformationEstimationForGeneralizedICP(), end)
                     .transformation_);
}

/// Weights end at a quarter of the gate.
Pose tukey(const std::vector<Vec3>& first, const std::vector<Vec3>& second, const Pose& guess, double spacing,
           double gate) {
  const auto target = prepare(first, 2 * spacing), source = prepare(second, 2 * spacing);
  const o3d::TransformationEstimationPointToPlane estimation(std::make_shared<o3d::TukeyLoss>(gate / 4));
  return pose_of(o3d::RegistrationICP(*source, *target, gate, matrix_of(guess), estimation, end).transformation_);
}

}  // namespace

std::vector<Method> open3d_methods() {
  std::vector<Method> result;
  for (const double gate : {0.2, 0.5})
    for (const auto& [name, align] : {std::pair{"gicp", &gicp}, std::pair{"plane, Tukey", &tukey}})
      result.push_back({std::string("Open3D ") + name, gate, align});
  return result;
}

}  // namespace peers

#else

namespace peers {

std::vector<Method> open3d_methods() { return {}; }

}  // namespace peers

#endif
