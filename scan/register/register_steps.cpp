#include "scan/register/register_steps.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "core/statistics.h"
#include "geometry/decompose.h"

namespace partscribe::scan {

void add_pair(std::size_t a, std::size_t b, const Mat6& block, Eigen::MatrixXd& all) {
  if (a > 0) all.block<6, 6>(first_unknown(a), first_unknown(a)) += block;
  if (b > 0) all.block<6, 6>(first_unknown(b), first_unknown(b)) += block;
  if (a == 0 || b == 0) return;
  all.block<6, 6>(first_unknown(a), first_unknown(b)) -= block,
      all.block<6, 6>(first_unknown(b), first_unknown(a)) -= block;
}

void add_pull(std::size_t a, std::size_t b, const Eigen::Matrix<double, 6, 1>& pull, Eigen::VectorXd& all) {
  if (a > 0) all.segment<6>(first_unknown(a)) += pull;
  if (b > 0) all.segment<6>(first_unknown(b)) -= pull;
}

Eigen::MatrixXd answer_of(const Eigen::MatrixXd& h, const Eigen::MatrixXd& basis) {
  Eigen::MatrixXd within = basis.transpose() * h * basis;
  within.diagonal() *= 1 + 1e-9;
  return basis * solve_ldlt(within, Eigen::MatrixXd(basis.transpose()));
}

Pose moved_about(const Pose& pose, const Vec3& center, const Vec3& turn, const Vec3& shift) {
  const Mat3 rotation = rotation_of(turn);
  return Pose{rotation, center + shift - rotation * center} * pose;
}

double spread_of(std::vector<double> residuals) {
  for (double& e : residuals) e = std::abs(e);
  return 1.4826 * median(std::move(residuals));
}

}  // namespace partscribe::scan
