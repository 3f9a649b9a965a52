/// Systematic errors that the points of one view (or region) share: the view stands a little wrong.
#pragma once

#include <vector>

#include "fit/normal_equations.h"

namespace partscribe {

/// Weighted sums over the points of one group. A row's six motion columns say how its distance answers to a shift and a
/// turn of the group.
struct GroupSums {
  Matrix motion;       ///< 6 x 6: sum of w * v v^T
  Matrix coupling;     ///< 6 x unknowns: sum of w * v j^T
  Vector pull;         ///< 6: sum of w * residual * v
};

struct GroupEffects {
  double shift = 0, turn = 0;  ///< mm, standard deviation along each axis; turn at the size's distance from the centre
  Matrix covariance;           ///< of the unknowns, mm^2, widened for the small number of groups
};

/// Random effects: every group has a shift and a turn of its own, with two variances common to all groups, estimated by
/// restricted maximum likelihood (Patterson & Thompson 1971) from how the groups' residuals disagree. Compared with a
/// jackknife over views, all six motions of all views tell one story, and a feature that only one view saw gets its
/// share. `h` is the normal matrix of the unknowns with the same weights, `noise` the variance of a residual of unit
/// weight, correlation included.
GroupEffects group_effects(const std::vector<GroupSums>& groups, const Matrix& h_inverse, double noise);

}  // namespace partscribe
