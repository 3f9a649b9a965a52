/// Systematic errors that the points of one view (or region) share: the view stands a little wrong.
#pragma once

#include "fit/refine/normal_equations.h"

namespace partscribe::fit {

/// Weighted sums over all points, by group. The six motion columns v of a point are the derivatives of its distance by
/// a shift and a rotation of its group; each group has six rows and columns. For a point that belongs partly to several
/// groups, v is multiplied by its share in each.
struct GroupSums {
  Matrix motion;    ///< sum of w * v v^T
  Matrix coupling;  ///< sum of w * v j^T, one column per unknown
  Vector pull;      ///< sum of w * residual * v
};

/// How far groups are off: standard deviations along (about) each axis, mm, widened for what few groups leave open
/// about them.
struct GroupEffects {
  double shift = 0;
  double turn = 0;  ///< at the size's distance from the centre
};

/// `tied`: shifts and turns are as large, for data that tell only one of them.
enum class Motions { apart, tied };

/// Random effects: every group has a shift and a rotation of its own. Their variances are common to all groups and are
/// estimated by restricted maximum likelihood (Patterson & Thompson 1971) from how the groups' residuals disagree.
/// Unlike a jackknife over views, this uses all six motions of all views together, and also covers a feature that only
/// one view saw. `h_inverse` is the inverse of the normal matrix of the unknowns with the same weights, `noise` the
/// variance of a residual of unit weight, correlation included.
GroupEffects group_effects(const GroupSums& groups, const Matrix& h_inverse, double noise, Motions motions);

/// Of the unknowns, mm^2: what such motions do to a fit whose inverse normal matrix is `h_inverse`.
Matrix covariance_of(const GroupEffects& effects, const GroupSums& groups, const Matrix& h_inverse);

}  // namespace partscribe::fit
