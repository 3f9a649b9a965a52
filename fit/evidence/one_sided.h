/// Where a view saw a face on one side of a place only: the mean over what it saw there is not the place's own.
#pragma once

#include "fit/refine/all_points.h"

namespace partscribe::fit {

/// Per node, mm along the normal: how far a mean over the neighbours of the same view and face lies off the surface,
/// whose pixels have that `variance` per axis, mm^2, as a view sees it. Beside a step or a silhouette, which the part
/// alone does not show: the shadow of one face ends in the midst of another. 0 where views or rays are unknown, and
/// where neighbours are all around.
std::vector<double> one_sided_mean(const AllPoints& all, double variance, int threads);

}  // namespace partscribe::fit
