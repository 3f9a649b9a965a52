// PCL: the refinement of its sample consensus models from the given start, all points inliers. Its points are floats.
#include "peers.h"

#if __has_include(<pcl/sample_consensus/sac_model_cone.h>)
#include <pcl/point_types.h>
#include <pcl/sample_consensus/sac_model_circle3d.h>
#include <pcl/sample_consensus/sac_model_cone.h>
#include <pcl/sample_consensus/sac_model_cylinder.h>
#include <pcl/sample_consensus/sac_model_line.h>
#include <pcl/sample_consensus/sac_model_plane.h>
#include <pcl/sample_consensus/sac_model_sphere.h>

#include <cmath>

namespace peers {
namespace {

using partscribe::geometry::Primitive;
using partscribe::geometry::PrimitiveKind;
using partscribe::geometry::Vec3;
using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Model = pcl::SampleConsensusModel<pcl::PointXYZ>;

Model::Ptr model_of(PrimitiveKind kind, const Cloud::ConstPtr& cloud) {
  switch (kind) {
    case PrimitiveKind::plane:
      return Model::Ptr(new pcl::SampleConsensusModelPlane<pcl::PointXYZ>(cloud));
    case PrimitiveKind::line:
      return Model::Ptr(new pcl::SampleConsensusModelLine<pcl::PointXYZ>(cloud));
    case PrimitiveKind::circle:
      return Model::Ptr(new pcl::SampleConsensusModelCircle3D<pcl::PointXYZ>(cloud));
    case PrimitiveKind::sphere:
      return Model::Ptr(new pcl::SampleConsensusModelSphere<pcl::PointXYZ>(cloud));
    case PrimitiveKind::cylinder:
      return Model::Ptr(new pcl::SampleConsensusModelCylinder<pcl::PointXYZ, pcl::Normal>(cloud));
    case PrimitiveKind::cone:
      return Model::Ptr(new pcl::SampleConsensusModelCone<pcl::PointXYZ, pcl::Normal>(cloud));
    default:
      return {};
  }
}

Eigen::VectorXf coefficients_of(const Primitive& p) {
  const Vec3 apex =
      p.kind == PrimitiveKind::cone ? Vec3(p.point - p.axis * (p.radius / std::tan(p.half_angle))) : p.point;
  Eigen::VectorXf c(7);
  c << static_cast<float>(apex.x()), static_cast<float>(apex.y()), static_cast<float>(apex.z()),
      static_cast<float>(p.axis.x()), static_cast<float>(p.axis.y()), static_cast<float>(p.axis.z()), 0.f;
  const auto radius = static_cast<float>(p.radius);
  switch (p.kind) {
    case PrimitiveKind::plane:
      return Eigen::Vector4f(c[3], c[4], c[5], static_cast<float>(-p.axis.dot(p.point)));
    case PrimitiveKind::line:
      return c.head<6>();
    case PrimitiveKind::sphere:
      return Eigen::Vector4f(c[0], c[1], c[2], radius);
    case PrimitiveKind::circle:
      c << c[0], c[1], c[2], radius, c[3], c[4], c[5];
      return c.eval();
    case PrimitiveKind::cone:
      c[6] = static_cast<float>(p.half_angle);
      return c;
    default:
      c[6] = radius;
      return c;
  }
}

Primitive primitive_of(PrimitiveKind kind, const Eigen::VectorXf& f, const Vec3& near) {
  const Eigen::VectorXd c = f.cast<double>();
  Primitive p;
  p.kind = kind;
  switch (kind) {
    case PrimitiveKind::plane: {
      p.axis = c.head<3>().normalized();
      p.point = near - p.axis * (p.axis.dot(near) + c[3] / c.head<3>().norm());
      break;
    }
    case PrimitiveKind::sphere:
      p.point = c.head<3>(), p.radius = c[3];
      break;
    case PrimitiveKind::circle:
      p.point = c.head<3>(), p.radius = c[3], p.axis = c.segment<3>(4).normalized();
      break;
    default:
      p.point = c.head<3>(), p.axis = c.segment<3>(3).normalized();
  }
  if (kind == PrimitiveKind::cylinder) p.radius = c[6];
  if (kind == PrimitiveKind::cone) {
    p.half_angle = c[6];
    const double height = (near - p.point).dot(p.axis);
    p.point += height * p.axis;
    p.radius = height * std::tan(p.half_angle);
  }
  return p;
}

Fit prepare(const Question& question) {
  if (question.kind == PrimitiveKind::torus) return {};
  Cloud::Ptr cloud(new Cloud);
  for (const Vec3& q : question.points)
    cloud->push_back({static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z())});
  const Model::Ptr model = model_of(question.kind, cloud);
  auto inliers = std::make_shared<pcl::Indices>();
  for (std::size_t i = 0; i < cloud->size(); ++i) inliers->push_back(static_cast<int>(i));
  const Primitive start = question.start;
  return [model, inliers, start]() -> std::optional<Primitive> {
    Eigen::VectorXf optimized;
    model->optimizeModelCoefficients(*inliers, coefficients_of(start), optimized);
    if (optimized.size() < 4) return {};
    return primitive_of(start.kind, optimized, start.point);
  };
}

}  // namespace

Prepare pcl_fits() { return prepare; }

}  // namespace peers
#else
namespace peers {
Prepare pcl_fits() { return {}; }
}  // namespace peers
#endif
