/// Cubic splines over a list of parameters: least squares with many right-hand sides at once, and what each knot adds.
///
/// Data on a grid have normal equations that are a product of one such system for each direction (de Boor 1978,
/// chapter XVII), so a net is found by two banded Cholesky solves.
#pragma once

#include <span>
#include <vector>

#include "geometry/surfaces/nurbs.h"

namespace partscribe::fit {

/// Without one of the knots at t.
KnotVector without_one(const KnotVector& knots, double t);

class LineBasis {
 public:
  /// `lines`: ascending parameters of the data, in the domain of `knots`, which are cubic and clamped; must outlive
  /// this.
  LineBasis(std::span<const double> lines, KnotVector knots) : LineBasis(lines, std::move(knots), nullptr) {}
  /// The same, quicker where `near` has the same lines and as many knots, most of them equal.
  LineBasis(std::span<const double> lines, KnotVector knots, const LineBasis& near)
      : LineBasis(lines, std::move(knots), &near) {}

  const KnotVector& knots() const { return knots_; }
  std::size_t count() const { return std::size_t(knots_.count()); }
  std::size_t lines() const { return first_.size(); }

  /// Adds `share` of the values of `sum.size()` splines at a line; `controls`: as many for each function.
  void add_values(std::size_t line, double share, std::span<const double> controls, std::span<double> sum) const {
    const std::size_t width = sum.size();
    const double *n = &value_[4 * line], *c = &controls[first_[line] * width];
    for (std::size_t k = 0; k < 4; ++k, c += width)
      for (std::size_t w = 0; w < width; ++w) sum[w] += share * n[k] * c[w];
  }
  /// Control values of the splines that are nearest to `values`, `width` at each line.
  std::vector<double> nearest(std::span<const double> values, std::size_t width) const;

  /// The spline that can no longer be said once one of the knots at t has gone: its values at the lines, of which the
  /// squares add up to 1; it is orthogonal to all that can still be said.
  struct Share {
    std::size_t begin = 0, end = 0;  ///< lines beyond are nearly zero
    std::vector<double> values;      ///< of the lines begin .. end
  };
  Share share_of(double t) const;

 private:
  LineBasis(std::span<const double> lines, KnotVector knots, const LineBasis* near);
  void solve(double* right, std::size_t width) const;

  KnotVector knots_;
  std::vector<std::uint32_t> first_;  // of each line: the control value of its first function
  std::vector<double> value_;         // four for each line
  std::vector<double> factor_;        // rows of Cholesky's lower triangle: three before the diagonal, one over it
};

}  // namespace partscribe::fit
