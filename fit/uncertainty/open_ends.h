/// Numbers that no point fixes on one side: the data end there.
#pragma once

#include "core/context.h"
#include "fit/refine/all_points.h"
#include "fit/refine/unknowns.h"

namespace partscribe::fit {

/// A length that may grow, alone or together with other numbers and the place, without a residual that changes.
struct OpenEnd {
  std::size_t parameter = 0;  ///< of the candidate
  double sigma = 0;           ///< mm, of the place where the data end
  double reach = 0;           ///< mm, of the last ten points before the end
  bool unlimited = false;     ///< ten points stand against it on one side only
};

/// Finds the lengths that the data leave open, moves each to the most likely end, and says how uncertain that is. None
/// for a closed mesh.
///
/// A free length is open if at most hardly_any_points or, in scans without many outliers, a hundredth of all points
/// depend on it or on a combination of it with other numbers. They are counted by squared derivatives: eigenvalues of
/// the normal matrix.
///
/// Beyond the end, a wall is assumed to have as many points per millimetre as in the last ten points before it, so that
/// each empty millimetre costs as many nats as points are missing from it. `candidate` is moved to the end of least
/// cost, but not with many outliers, which it would follow.
///
/// sigma is a third of the range that holds the end with a probability of 95 %, because the end is distributed
/// exponentially; it is at least half the distance of neighbouring points there. If the length is limited on both
/// sides, sigma is a quarter of the range in which the cost is less than 2 nats (two sigmas) above its least. `noise`
/// is in mm.
std::vector<OpenEnd> settle_open_ends(Candidate& candidate, const AllPoints& all, const Unknowns& unknowns,
                                      const std::vector<Vec3>& points, const FitInput& input, double noise,
                                      Context& context);

}  // namespace partscribe::fit
