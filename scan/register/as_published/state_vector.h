/// The registration state vector q of 1993, and the mean square error e(q) that it makes least (section 2.1.1).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::scan {

/// A displacement of points: p becomes R(q_R) p + q_T.
struct StateVector {
  Eigen::Vector4d rotation{1, 0, 0, 0};  ///< q_R: unit quaternion, real part first and not negative
  Vec3 translation = Vec3::Zero();       ///< q_T, mm
};

/// R(q_R).
Mat3 rotation_matrix(const StateVector& q);

Pose pose_of(const StateVector& q);
StateVector state_of(const Pose& pose);

/// The displacement `earlier` followed by `later`: how the consecutive ones become the solution.
StateVector cumulated(const StateVector& later, const StateVector& earlier);

/// e(q) = (1/N) sum |x_i - R(q_R) p_i - q_T|^2, mm^2; p and x are as long, and not empty.
double mean_square_error(const std::vector<Vec3>& p, const std::vector<Vec3>& x, const StateVector& q);

/// q_0, for which e(q) is least: the quaternion is the eigenvector of the largest eigenvalue of N (Besl & McKay 1992,
/// equations 25 and 26). Three points that are on no line fix it; of fewer it is one of many.
StateVector best_state(const std::vector<Vec3>& p, const std::vector<Vec3>& x);

}  // namespace partscribe::scan
