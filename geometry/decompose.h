/// Eigen's decompositions of the usual sizes, compiled once: a compiler takes seconds for each in every file that asks.
#pragma once

#include <Eigen/Core>

#include "core/layers.h"

namespace partscribe::geometry {

/// x of a x = b by a pivoted Cholesky decomposition (LDLT), of which `a` is the lower half. What is declared but not
/// instantiated in decompose.cpp is found missing by the linker: add it there.
template <int n, int columns>
Eigen::Matrix<double, n, columns> solve_ldlt(const Eigen::Matrix<double, n, n>& a,
                                             const Eigen::Matrix<double, n, columns>& b);

/// Of a symmetric matrix, the smallest value first; eigenvectors are columns of unit length.
template <int n>
struct Eigensystem {
  Eigen::Matrix<double, n, 1> values;
  Eigen::Matrix<double, n, n> vectors;
};

/// Reads the lower half. Three by three is for Eigen's own solver, which is light.
template <int n>
Eigensystem<n> eigensystem(const Eigen::Matrix<double, n, n>& a);

/// Of a symmetric matrix, the smallest first.
Eigen::VectorXd eigenvalues_of(const Eigen::MatrixXd& a);

/// a v = lambda b v with positive definite `b`, v' b v = 1.
Eigensystem<Eigen::Dynamic> generalized_eigensystem(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

}  // namespace partscribe::geometry
