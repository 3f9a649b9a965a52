#include "scan/register/as_published/state_vector.h"

#include <Eigen/Geometry>

#include "core/ensure.h"
#include "geometry/decompose.h"

namespace partscribe::scan {
namespace {

Eigen::Quaterniond quaternion_of(const StateVector& q) {
  return {q.rotation[0], q.rotation[1], q.rotation[2], q.rotation[3]};
}

/// Of the two quaternions of a rotation the one whose real part is not negative.
Eigen::Vector4d one_of_both(const Eigen::Quaterniond& q) {
  const Eigen::Vector4d r(q.w(), q.x(), q.y(), q.z());
  return r[0] < 0 ? Eigen::Vector4d(-r) : r;
}

}  // namespace

Mat3 rotation_matrix(const StateVector& q) { return quaternion_of(q).toRotationMatrix(); }

Pose pose_of(const StateVector& q) { return {rotation_matrix(q), q.translation}; }

StateVector state_of(const Pose& pose) {
  return {one_of_both(Eigen::Quaterniond(pose.rotation).normalized()), pose.translation};
}

StateVector cumulated(const StateVector& later, const StateVector& earlier) {
  return {one_of_both((quaternion_of(later) * quaternion_of(earlier)).normalized()),
          rotation_matrix(later) * earlier.translation + later.translation};
}

double mean_square_error(const std::vector<Vec3>& p, const std::vector<Vec3>& x, const StateVector& q) {
  ensure(p.size() == x.size() && !p.empty(), "every point has its match");
  const Mat3 R = rotation_matrix(q);
  double sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i) sum += (x[i] - R * p[i] - q.translation).squaredNorm();
  return sum / static_cast<double>(p.size());
}

StateVector best_state(const std::vector<Vec3>& p, const std::vector<Vec3>& x) {
  ensure(p.size() == x.size() && !p.empty(), "every point has its match");
  const double share = 1 / static_cast<double>(p.size());
  Vec3 p_mean = Vec3::Zero(), x_mean = Vec3::Zero();
  for (std::size_t i = 0; i < p.size(); ++i) p_mean += share * p[i], x_mean += share * x[i];
  Mat3 S = Mat3::Zero();
  for (std::size_t i = 0; i < p.size(); ++i) S += share * (p[i] - p_mean) * (x[i] - x_mean).transpose();
  const Vec3 d(S(1, 2) - S(2, 1), S(2, 0) - S(0, 2), S(0, 1) - S(1, 0));
  Eigen::Matrix4d N;
  N << S.trace(), d.transpose(), d, S + S.transpose() - S.trace() * Mat3::Identity();
  const Eigen::Vector4d q = eigensystem(N).vectors.col(3);
  StateVector state;
  state.rotation = one_of_both(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized());
  state.translation = x_mean - rotation_matrix(state) * p_mean;
  return state;
}

}  // namespace partscribe::scan
