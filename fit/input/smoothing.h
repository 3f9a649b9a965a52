/// Noise that hangs together: whether it was smoothed, and what that did to the surface.
#pragma once

#include <optional>

#include "fit/refine/all_points.h"
#include "fit/uncertainty/group_sums.h"
#include "model/distance.h"

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

/// How likely the noise was smoothed, by a filter or in the making of a mesh, rather than born so; even odds
/// beforehand. Only smoothing disturbs rims: it rounds edges off, and beside a step or a silhouette it takes its mean
/// from one side. `residuals` of the points, mm. Nothing if there are too few rims to tell; where all is rim, 0 or
/// nothing.
std::optional<double> chance_by_rims(const AllPoints& all, const std::vector<double>& residuals, const Deviation& rim,
                                     double points_per_independent);

/// The Jacobian with what a smoothing does as further unknowns, so that neither the fit nor the views are held
/// responsible.
struct SmoothingModel {
  Matrix rows;
  Eigen::Index further = 0;  ///< columns at the end
  double precision = 0;      ///< of a further unknown beforehand: about as deep as predicted, either way
};

/// The effect on faces, one unknown for each of `bins` of incidence: how deep a filter goes on a slope is its maker's
/// secret.
SmoothingModel smoothing_model(const AllPoints& all, const Deviation& face, double noise, int bins);

/// The effect on rims, one unknown for every face, as far as it is believed (`chance`).
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
