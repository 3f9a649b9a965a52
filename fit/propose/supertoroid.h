/// Recovers one supertoroid from unorganised, noisy, partial points.
#pragma once

#include <vector>

#include "fit/candidate.h"
#include "fit/propose/revolve.h"

namespace partscribe::fit {

/// A recovered supertoroid and where it stands.
struct SupertoroidFit {
  SupertoroidOf<double> shape;
  Pose scan_from_shape;
  double miss = 1e300;  ///< mm, median distance of the points to first order
};

/// Robust least squares of the first-order distance (N - 1) / |grad N| over place, sizes and exponents, from several
/// starts about each of `axes`: points lie on the surface with Gaussian noise, which falls from round to round, or
/// anywhere. No fit (an infinite miss) where every start has closed its hole. Uses at most some 800 points.
SupertoroidFit recover_supertoroid(const std::vector<Vec3>& points, const std::vector<Axis>& axes, Context& context);

}  // namespace partscribe::fit
