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

/// None of a closed mesh. The free lengths, or combinations with other numbers, that at most hardly_any_points or (of
/// scans without many outliers) a hundredth of all points depend on, counted by squared derivatives (eigenvectors of
/// the normal matrix). Points on the walls are assumed to be as dense beyond the end as the last ten before it, so that
/// an empty millimetre costs as many nats as there should be points on it. If the wall continues beyond the end,
/// `candidate` is moved to the place of least cost (not with many outliers). sigma is a third of the range that holds
/// the place in 95 % (it is exponentially distributed); of a length that is limited on either side, a quarter of the
/// two-sigma range. The end of the data is never known to less than half the distance of neighbouring points. `noise`
/// in mm.
std::vector<OpenEnd> settle_open_ends(Candidate& candidate, const AllPoints& all, const Unknowns& unknowns,
                                      const std::vector<Vec3>& points, const FitInput& input, double noise,
                                      Context& context);

}  // namespace partscribe::fit
