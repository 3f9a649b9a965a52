/// Correlated noise: whether a smoothing filter caused it, and how that filter displaced the surface.
#pragma once

#include <optional>

#include "fit/refine/all_points.h"
#include "fit/uncertainty/group_sums.h"
#include "model/distance/distance.h"

namespace partscribe::fit {

/// A deviation of the data along the normal, mm, one number per node.
using Deviation = std::vector<double>;

/// What a smoothing does: it replaces each place by the mean of its surroundings, which bend away from the tangent
/// plane.
struct SmoothingEffect {
  Deviation face;  ///< from the curvature of the node's own face
  Deviation rim;   ///< from other faces within reach, which round the edge off; 0 for nodes well inside their face
};

/// `variance` of the smoothing per axis, mm^2, as a view sees it.
SmoothingEffect smoothing_effect(const Candidate& candidate, const AllPoints& all, double variance,
                                 const ModelDistance& distance, int threads);

/// Probability (prior 1/2) that the correlation comes from smoothing, by a filter or when the mesh was made, and not
/// from the sensor. Only smoothing disturbs rims: it rounds edges off, and beside a step or a silhouette it averages
/// over one side only. `residuals` of the points, mm. Nothing if there are too few points near rims to decide; 0 or
/// nothing if all points are near rims.
std::optional<double> chance_by_rims(const AllPoints& all, const std::vector<double>& residuals, const Deviation& rim,
                                     double points_per_independent);

/// The Jacobian with the effect of smoothing as further unknowns, so that it is attributed neither to the fit nor to
/// the poses of views.
struct SmoothingModel {
  Matrix rows;
  Eigen::Index further = 0;  ///< columns at the end
  double precision = 0;      ///< prior precision of a further unknown: about the predicted depth, of either sign
};

/// The effect on faces, one unknown for each of `bins` of the angle of incidence, because how a filter acts on slopes
/// is not documented.
SmoothingModel smoothing_model(const AllPoints& all, const Deviation& face, double noise, int bins);

/// The effect on rims, one unknown for every face, weighted by the probability `chance` that there was smoothing.
SmoothingModel rim_model(const AllPoints& all, const Deviation& rim, const Deviation& one_sided, double chance,
                         double noise);

struct Solution {
  Matrix inverse;
  Vector unknowns;
};

/// Least squares from the sums over the points with `model.rows`.
Solution solved(const SmoothingModel& model, const PointSums& sums, int threads);

/// Distances of the points without what `solution` explains, mm.
std::vector<double> left_over(const AllPoints& all, const SmoothingModel& model, const Solution& solution);

/// As chance_by_rims, from the further unknowns: a filter of range images errs on slopes otherwise than where the
/// surface faces the sensor. By the ratio of the marginal likelihoods with and without them.
double chance_by_incidence(const SmoothingModel& model, const Solution& solution, double noise);

}  // namespace partscribe::fit
