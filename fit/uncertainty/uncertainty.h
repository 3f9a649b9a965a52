/// What the data leave open about a fit's numbers: noise, and what does not average out.
#pragma once

#include "fit/refine/all_points.h"

namespace partscribe::fit {

/// Standard deviations of the free parameters, in their own units, by cause.
struct Uncertainty {
  std::vector<double> noise;  ///< falls with the number of independent points
  /// disagreement of views: registration, calibration; of hypothetical views where they are unknown
  std::vector<double> views;
  std::vector<double> poses;   ///< where registered views may stand, as registration says
  std::vector<double> facets;  ///< chords of a coarse source mesh
  std::vector<double> filter;  ///< smoothing that flattened curved faces, weighted by the probability that correlated
                               ///< noise comes from smoothing
  std::vector<double> slant;   ///< noise along rays that nobody knows, on a curved part seen from one side (slant.h)
  Vector correction;           ///< of the unknowns: removes the effect of smoothing on rims; empty: none
  double floor = 0;            ///< mm, what no data can tell about the instrument
  double points_per_independent = 1;
  double rms = 0;  ///< mm, of the residuals that count
};

/// At the result of polish(). Noise: the sandwich covariance of an M-estimator, E psi^2 / (E psi')^2 (sum J J^T /
/// sigma^2)^-1 [Huber 1967], times the number of points per independent one. The noise of the points of a smoothed scan
/// is estimated again without rims, as at least `least_sigma`.
Uncertainty uncertainty_of(const Candidate& candidate, AllPoints& all, const FitInput& input, const Unknowns& unknowns,
                           double least_sigma, const Welsch& kernel, Context& context);

}  // namespace partscribe::fit
