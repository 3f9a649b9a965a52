/// Which round size a measured one was meant to be: metric and inch series, preferred numbers, drills and threads.
#pragma once

#include <optional>
#include <vector>

#include "model/model.h"

namespace partscribe::fit {

/// One answer per parameter: the nominal size that it may have been meant to be, its z, its series, its probability,
/// and whether it is taken. No answer where no series has a value nearby, and none for counts, ratios and parameters
/// without sigma.
///
/// A parameter is either arbitrary (any value nearby is as likely as any other) or meant to be a value of one of the
/// series. Where neighbouring values of a series lie g apart, the likelihood ratio of the second to the first is g /
/// (sqrt(2 pi) sigma) exp(-z^2 / 2). All parameters of a part share two unknowns, which are integrated out: the
/// designer's habit (metric or inch, and the step of which most sizes are multiples) and the share of its sizes that
/// are nominal. So one more round size is credible on a part full of round sizes. On a worn part, whose sizes miss
/// every series by many sigmas, the one size that happens to hit a fine grid is not.
///
/// A nominal size is taken if its probability is at least 0.9, |z| <= 2.6, and it moves the surface by at most a
/// quarter of the tolerance (an angle does so at the distance `size`, mm). Diameters of holes are also compared with
/// those of drills, clearance holes and tap holes.
std::vector<std::optional<NominalEvidence>> nominal_values(const std::vector<Parameter>& parameters, double tolerance,
                                                           double size);

}  // namespace partscribe::fit
