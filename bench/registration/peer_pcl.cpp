// PCL: GICP, NDT, and point to plane with rejected partners. Its points are floats; clouds are moved to the origin
// first.
#include "peers.h"

#ifdef PARTSCRIBE_HAS_PCL
#include <pcl/features/normal_3d.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_types.h>
#include <pcl/registration/correspondence_rejection_median_distance.h>
#include <pcl/registration/correspondence_rejection_surface_normal.h>
#include <pcl/registration/correspondence_rejection_trimmed.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/ndt.h>
#include <pcl/search/kdtree.h>

#include <Eigen/Geometry>
#include <cmath>

namespace peers {
namespace {

using partscribe::geometry::Pose;
using partscribe::geometry::Vec3;
using Point = pcl::PointXYZ;
using Cloud = pcl::PointCloud<Point>;
using WithNormals = pcl::PointCloud<pcl::PointNormal>;

Vec3 middle_of(const std::vector<Vec3>& points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : points) sum += p;
  return sum / double(points.size());
}

Cloud::Ptr thinned(const std::vector<Vec3>& points, const Vec3& middle, double voxel) {
  Cloud::Ptr cloud(new Cloud), result(new Cloud);
  for (const Vec3& p : points)
    cloud->push_back(Point(float(p.x() - middle.x()), float(p.y() - middle.y()), float(p.z() - middle.z())));
  pcl::VoxelGrid<Point> grid;
  grid.setInputCloud(cloud);
  grid.setLeafSize(float(voxel), float(voxel), float(voxel));
  grid.filter(*result);
  return result;
}

WithNormals::Ptr with_normals(const Cloud::Ptr& cloud) {
  pcl::NormalEstimation<Point, pcl::Normal> estimation;
  estimation.setInputCloud(cloud);
  estimation.setSearchMethod(pcl::search::KdTree<Point>::Ptr(new pcl::search::KdTree<Point>));
  estimation.setKSearch(10);
  estimation.setViewPoint(0, 0, -1e6f);  // views look along +z
  pcl::PointCloud<pcl::Normal> normals;
  estimation.compute(normals);
  WithNormals::Ptr result(new WithNormals);
  for (std::size_t i = 0; i < cloud->size(); ++i) {
    pcl::PointNormal p;
    p.getVector3fMap() = (*cloud)[i].getVector3fMap(), p.getNormalVector3fMap() = normals[i].getNormalVector3fMap();
    if (std::isfinite(p.normal_x)) result->push_back(p);
  }
  return result;
}

/// Both clouds about the first one's middle; poses there and back.
struct Frame {
  Vec3 target, source;
  Eigen::Matrix4f start(const Pose& guess) const {
    Eigen::Matrix4f m = Eigen::Matrix4f::Identity();
    m.topLeftCorner<3, 3>() = guess.rotation.cast<float>();
    m.topRightCorner<3, 1>() = (guess * source - target).cast<float>();
    return m;
  }
  Pose end(const Eigen::Matrix4f& m) const {
    Pose p;
    // The nearest rotation: floats do not keep it exactly one.
    p.rotation = Eigen::Quaterniond(partscribe::geometry::Mat3(m.topLeftCorner<3, 3>().cast<double>()))
                     .normalized()
                     .toRotationMatrix();
    p.translation = m.topRightCorner<3, 1>().cast<double>() + target - p.rotation * source;
    return p;
  }
};

/// Ends when steps are below 1e-4 mm and rad, as small_gicp's; `epsilon` says so in the method's own terms.
template <class Registration, class Any>
Pose run(Registration& registration, const Any& target, const Any& source, const Frame& frame, const Pose& guess,
         double gate, double epsilon = 1e-8) {
  registration.setInputTarget(target);
  registration.setInputSource(source);
  registration.setMaxCorrespondenceDistance(gate);
  registration.setMaximumIterations(100);
  registration.setTransformationEpsilon(epsilon);
  typename Any::element_type moved;
  registration.align(moved, frame.start(guess));
  return frame.end(registration.getFinalTransformation());
}

Pose gicp(const std::vector<Vec3>& first, const std::vector<Vec3>& second, const Pose& guess, double spacing,
          double gate) {
  const Frame frame{middle_of(first), middle_of(second)};
  pcl::GeneralizedIterativeClosestPoint<Point, Point> registration;
  registration.setCorrespondenceRandomness(10);
  registration.setRotationEpsilon(1e-4);
  return run(registration, thinned(first, frame.target, 2 * spacing), thinned(second, frame.source, 2 * spacing), frame,
             guess, gate, 1e-4);
}

Pose ndt(const std::vector<Vec3>& first, const std::vector<Vec3>& second, const Pose& guess, double spacing,
         double gate) {
  const Frame frame{middle_of(first), middle_of(second)};
  pcl::NormalDistributionsTransform<Point, Point> registration;
  registration.setResolution(float(gate / 2));
  registration.setStepSize(gate / 4);
  return run(registration, thinned(first, frame.target, 2 * spacing), thinned(second, frame.source, 2 * spacing), frame,
             guess, gate);
}

template <bool trimmed>
Pose plane(const std::vector<Vec3>& first, const std::vector<Vec3>& second, const Pose& guess, double spacing,
           double gate) {
  const Frame frame{middle_of(first), middle_of(second)};
  pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal> registration;
  pcl::registration::CorrespondenceRejectorSurfaceNormal::Ptr turned(
      new pcl::registration::CorrespondenceRejectorSurfaceNormal);
  turned->setThreshold(std::cos(0.785));
  if constexpr (trimmed) {
    pcl::registration::CorrespondenceRejectorTrimmed::Ptr best(new pcl::registration::CorrespondenceRejectorTrimmed);
    best->setOverlapRatio(0.7f);
    registration.addCorrespondenceRejector(best);
  } else {
    pcl::registration::CorrespondenceRejectorMedianDistance::Ptr near(
        new pcl::registration::CorrespondenceRejectorMedianDistance);
    near->setMedianFactor(2);
    registration.addCorrespondenceRejector(near);
  }
  registration.addCorrespondenceRejector(turned);
  return run(registration, with_normals(thinned(first, frame.target, 2 * spacing)),
             with_normals(thinned(second, frame.source, 2 * spacing)), frame, guess, gate);
}

}  // namespace

std::vector<Method> pcl_methods() {
  std::vector<Method> result;
  for (const double gate : {0.2, 0.5})
    for (const auto& [name, align] :
         {std::pair{"gicp", &gicp}, std::pair{"ndt", &ndt}, std::pair{"plane, median and normals", &plane<false>},
          std::pair{"plane, trimmed and normals", &plane<true>}})
      result.push_back({std::string("PCL ") + name, gate, align});
  return result;
}

}  // namespace peers

#else

namespace peers {

std::vector<Method> pcl_methods() { return {}; }

}  // namespace peers

#endif
