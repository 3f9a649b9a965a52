/// The sums over points that the effects of views and regions are estimated from.
#pragma once

#include "fit/refine/all_points.h"
#include "fit/uncertainty/group_effects.h"

namespace partscribe::fit {

/// By node and by group, as if the kernel were least squares: a residual is psi(u) sigma / E psi', a weight 1 /
/// sigma^2.
struct PointSums {
  std::vector<double> weight, pull;  ///< per node
  GroupSums groups;
};

/// Of all points, those of node k with `share[k]` of their weight. `rows` are the derivatives, one row per node;
/// `slope` is E psi'.
PointSums sums_of(const AllPoints& all, const Matrix& rows, const std::vector<double>& share, const Unknowns& unknowns,
                  const Welsch& kernel, double slope, int threads);

/// For points whose views are unknown: the sums for assumed views from all around, each of which saw what faces it. A
/// place takes the mean error of the views that saw it. That is smaller than the error of one region, and extends
/// farther.
GroupSums sums_of_imagined_views(const AllPoints& all, const Matrix& rows, const PointSums& sums,
                                 const Unknowns& unknowns);

}  // namespace partscribe::fit
