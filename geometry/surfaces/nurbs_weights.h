/// Control points and weights of a B-spline curve from points at once, where a polynomial curve would need many more.
#pragma once

#include <vector>

#include "geometry/surfaces/nurbs.h"

namespace partscribe::geometry {

/// A rational curve and how far the points are from it, mm.
template <int D>
struct WeightFit {
  NurbsCurve<D> curve;
  double rms = 0, largest = 0;
};

/// The curve over the knots of `start` with the least sum of squared distances to `places`, found from there by damped
/// steps, each with new feet of all places; its ends stay where they are, and its first weight is 1. All weights stay
/// within a factor of 100 of it. A start with its weights empty is taken to have weights of 1. (Weights as unknowns of
/// the 1993 paper, section 3.2, "may be adjusted later in refinement"; by distance, not at fixed parameters.)
WeightFit<2> with_fitted_weights(const NurbsCurve<2>& start, const std::vector<Vec2>& places);
WeightFit<3> with_fitted_weights(const NurbsCurve<3>& start, const std::vector<Vec3>& places);

}  // namespace partscribe::geometry
