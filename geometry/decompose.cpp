#include "geometry/decompose.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace partscribe::geometry {

using Eigen::Dynamic;
using Eigen::Matrix;

namespace {

/// Up to six by six, in place of a size of its own for each: one decomposition to compile.
using Small = Matrix<double, Dynamic, Dynamic, Eigen::ColMajor, 6, 6>;

Small solve_small(const Small& a, const Small& b) { return a.ldlt().solve(b); }

}  // namespace

template <int n, int columns>
Matrix<double, n, columns> solve_ldlt(const Matrix<double, n, n>& a, const Matrix<double, n, columns>& b) {
  if constexpr (n == Dynamic || n > 6)
    return a.ldlt().solve(b);
  else
    return solve_small(a, b);
}

template Matrix<double, 2, 1> solve_ldlt(const Matrix<double, 2, 2>&, const Matrix<double, 2, 1>&);
template Matrix<double, 3, 1> solve_ldlt(const Matrix<double, 3, 3>&, const Matrix<double, 3, 1>&);
template Matrix<double, 3, 3> solve_ldlt(const Matrix<double, 3, 3>&, const Matrix<double, 3, 3>&);
template Matrix<double, 4, 1> solve_ldlt(const Matrix<double, 4, 4>&, const Matrix<double, 4, 1>&);
template Matrix<double, 5, 1> solve_ldlt(const Matrix<double, 5, 5>&, const Matrix<double, 5, 1>&);
template Matrix<double, 6, 1> solve_ldlt(const Matrix<double, 6, 6>&, const Matrix<double, 6, 1>&);
template Matrix<double, 9, 1> solve_ldlt(const Matrix<double, 9, 9>&, const Matrix<double, 9, 1>&);
template Matrix<double, Dynamic, 1> solve_ldlt(const Matrix<double, Dynamic, Dynamic>&,
                                               const Matrix<double, Dynamic, 1>&);
template Matrix<double, Dynamic, Dynamic> solve_ldlt(const Matrix<double, Dynamic, Dynamic>&,
                                                     const Matrix<double, Dynamic, Dynamic>&);

template <>
Eigensystem<Dynamic> eigensystem(const Eigen::MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template <int n>
Eigensystem<n> eigensystem(const Matrix<double, n, n>& a) {
  const auto any_size = eigensystem(Eigen::MatrixXd(a));
  return {any_size.values, any_size.vectors};
}

template Eigensystem<2> eigensystem(const Matrix<double, 2, 2>&);
template Eigensystem<4> eigensystem(const Matrix<double, 4, 4>&);
template Eigensystem<6> eigensystem(const Matrix<double, 6, 6>&);

Eigen::VectorXd eigenvalues_of(const Eigen::MatrixXd& a) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigensystem<Dynamic> generalized_eigensystem(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(a, b);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace partscribe::geometry
