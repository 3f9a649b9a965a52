/// Normal equations of the poses of several views, and steps that follow from them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "geometry/vec.h"
#include "scan/register/register.h"

namespace partscribe::scan {

/// Six unknowns of each view but the first, whose pose stays: rotation vector about a center times a size, and shift,
/// mm.
inline Eigen::Index first_unknown(std::size_t view) { return static_cast<Eigen::Index>(6 * (view - 1)); }

/// Adds what holds one view against another: `block` to both, its opposite to what couples them.
void add_pair(std::size_t a, std::size_t b, const Mat6& block, Eigen::MatrixXd& all);

/// Adds what pulls the first view of a pair, and the second the other way.
void add_pull(std::size_t a, std::size_t b, const Eigen::Matrix<double, 6, 1>& pull, Eigen::VectorXd& all);

/// From pulls to steps, within the columns of `basis`.
Eigen::MatrixXd answer_of(const Eigen::MatrixXd& h, const Eigen::MatrixXd& basis);

/// `pose` after a turn (rad) about `center` and a shift.
Pose moved_about(const Pose& pose, const Vec3& center, const Vec3& turn, const Vec3& shift);

/// The standard deviation of residuals of which some are wild, from the median of their sizes.
double spread_of(std::vector<double> residuals);

}  // namespace partscribe::scan
