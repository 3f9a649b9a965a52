/// Weighted normal equations, summed in an order that does not depend on the number of threads.
#pragma once

#include <vector>

#include "fit/refine/unknowns.h"

namespace partscribe::fit {

struct NormalEquations {
  Matrix h;  ///< sum of weight * row row^T
  Vector g;  ///< sum of pull * row
};

/// `weight` and `pull` hold one number per row.
NormalEquations normal_equations(const Matrix& rows, const std::vector<double>& weight, const std::vector<double>& pull,
                                 int threads);

/// Inverse of a symmetric matrix without its free directions: eigenvalues below 1e-9 of their mean (the symmetries of a
/// shape, reference: orthogonal distance fits).
Matrix pseudo_inverse(const Matrix& h);

/// Welsch's redescending kernel at u = residual / scale, tuned by c (Holland & Welsch 1977). Against least squares on
/// Gaussian data it loses (1 + 1/c^2)^3 (1 + 2/c^2)^(-3/2) of variance: 2.9 % for c = 2.5, 1.5 % for 3.
///
/// If the density of outliers near the surface is known, a residual is weighted by the probability that it is not one
/// (EM of a Gaussian and a uniform background on either side): nearly 1 up to three sigmas, nearly 0 from four on, and
/// without bias to the side with more outliers.
struct Welsch {
  double c = 2.5;
  double before = 0,
         behind = 0;  ///< density of outliers over that of the surface's points where it is highest; 0: not known
  double weight(double u) const;  ///< psi / u
  double psi(double u) const { return u * weight(u); }
  double slope(double u) const;  ///< psi'
  double loss(double u) const;
};

/// Standard deviation of the Gaussian in the middle of `values` (about zero), whatever their tails.
double robust_scale(std::vector<double> values);

}  // namespace partscribe::fit
