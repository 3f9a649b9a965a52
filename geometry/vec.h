/// Vectors, boxes and rigid motions in millimetres.
#pragma once

#include <Eigen/Core>
#include <limits>

#include "core/layers.h"

namespace partscribe::geometry {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// An axis-parallel box; empty until something is added.
struct Box3 {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());
  bool empty() const { return !(low.x() <= high.x()); }
  void add(const Vec3& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
  Vec3 size() const { return empty() ? Vec3(0, 0, 0) : Vec3(high - low); }
  Vec3 center() const { return 0.5 * (low + high); }
  double diagonal() const { return size().norm(); }
};

/// A rigid motion, named `to_from`: `world_from_view * p_view` is the point in the world.
struct Pose {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();
  Vec3 operator*(const Vec3& p) const { return rotation * p + translation; }
  Pose operator*(const Pose& other) const {
    return {rotation * other.rotation, rotation * other.translation + translation};
  }
  Pose inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }
};

/// Rotation by |v| radians about v.
Mat3 rotation_of(const Vec3& rotation_vector);

/// R = Rz(z) Ry(y) Rx(x): x first, then y, then z, as OpenSCAD's rotate([x, y, z]). Radians.
Mat3 rotation_from_euler(const Vec3& angles);

/// The inverse of rotation_from_euler, with y in [-pi/2, pi/2].
Vec3 euler_from_rotation(const Mat3& rotation);

/// A rotation that takes the z axis onto the unit vector `axis`, the same for the same axis always.
Mat3 rotation_onto_axis(const Vec3& axis);

}  // namespace partscribe::geometry
