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

/// Robust least squares of the first-order distance (N - 1) / |grad N|, N being 1 on the surface, over place, sizes and
/// exponents, from several starts about each of `axes`. The points are modelled as a mixture: a Gaussian about the
/// surface, whose sigma is lowered from round to round, and outliers anywhere. No fit (`miss` is infinite) where the
/// data leave no hole about any axis. Uses at most some 800 points.
SupertoroidFit recover_supertoroid(const std::vector<Vec3>& points, const std::vector<Axis>& axes, Context& context);

}  // namespace partscribe::fit
