// small_gicp: point to point, point to plane, GICP and GICP against voxels, one thread, neighbours and ends as its
// authors advise.
#include "peers.h"

#if __has_include(<small_gicp/registration/registration.hpp>)
#include <memory>
#include <small_gicp/ann/gaussian_voxelmap.hpp>
#include <small_gicp/ann/kdtree.hpp>
#include <small_gicp/factors/gicp_factor.hpp>
#include <small_gicp/factors/icp_factor.hpp>
#include <small_gicp/factors/plane_icp_factor.hpp>
#include <small_gicp/points/point_cloud.hpp>
#include <small_gicp/registration/reduction.hpp>
#include <small_gicp/registration/registration.hpp>
#include <small_gicp/util/downsampling.hpp>
#include <small_gicp/util/normal_estimation.hpp>
#include <vector>

namespace peers {
namespace {

using partscribe::geometry::Pose;
using partscribe::geometry::Vec3;
using Tree = small_gicp::KdTree<small_gicp::PointCloud>;

struct Prepared {
  small_gicp::PointCloud::Ptr cloud;
  std::shared_ptr<Tree> tree;
};

Prepared prepare(const std::vector<Vec3>& points, double voxel) {
  Prepared result;
  result.cloud = small_gicp::voxelgrid_sampling(small_gicp::PointCloud(points), voxel);
  result.tree = std::make_shared<Tree>(result.cloud);
  small_gicp::estimate_normals_covariances(*result.cloud, *result.tree, 10);
  return result;
}

/// `search` finds partners in `target`; voxels are both.
template <typename Factor, typename Target, typename Search>
Pose run(const small_gicp::PointCloud& source, const Target& target, const Search& search, const Pose& guess,
         double gate) {
  small_gicp::Registration<Factor, small_gicp::SerialReduction> registration;
  registration.rejector.max_dist_sq = gate * gate;
  registration.criteria.rotation_eps = 1e-4, registration.criteria.translation_eps = 1e-4;
  registration.optimizer.max_iterations = 100;
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();
  start.linear() = guess.rotation, start.translation() = guess.translation;
  const auto found = registration.align(target, source, search, start);
  return {found.T_target_source.linear(), found.T_target_source.translation()};
}

Pose icp(const std::vector<Vec3>& first, const std::vector<Vec3>& second, const Pose& guess, double spacing,
         double gate) {
  const Prepared target = prepare(first, 2 * spacing), source = prepare(second, 2 * spacing);
  return run<small_gicp::ICPFactor>(*source.cloud, *target.cloud, *target.tree, guess, gate);
}

Pose plane(const std::vector<Vec3>& first, const std::vector<Vec3>& second, const Pose& guess, double spacing,
           double gate) {
  const Prepared target = prepare(first, 2 * spacing), source = prepare(second, 2 * spacing);
  return run<small_gicp::PointToPlaneICPFactor>(*source.cloud, *target.cloud, *target.tree, guess, gate);
}

Pose gicp(const std::vector<Vec3>& first, const std::vector<Vec3>& second, const Pose& guess, double spacing,
          double gate) {
  const Prepared target = prepare(first, 2 * spacing), source = prepare(second, 2 * spacing);
  return run<small_gicp::GICPFactor>(*source.cloud, *target.cloud, *target.tree, guess, gate);
}

Pose vgicp(const std::vector<Vec3>& first, const std::vector<Vec3>& second, const Pose& guess, double spacing,
           double gate) {
  const Prepared target = prepare(first, 2 * spacing), source = prepare(second, 2 * spacing);
  small_gicp::GaussianVoxelMap voxels(4 * spacing);
  voxels.insert(*target.cloud);
  return run<small_gicp::GICPFactor>(*source.cloud, voxels, voxels, guess, gate);
}

}  // namespace

std::vector<Method> small_gicp_methods() {
  std::vector<Method> result;
  for (const double gate : {0.2, 0.5})
    for (const auto& [name, align] :
         {std::pair{"icp", &icp}, std::pair{"plane", &plane}, std::pair{"gicp", &gicp}, std::pair{"vgicp", &vgicp}})
      result.push_back({std::string("small_gicp ") + name, gate, align});
  return result;
}

}  // namespace peers

#else

namespace peers {

std::vector<Method> small_gicp_methods() { return {}; }

}  // namespace peers

#endif
