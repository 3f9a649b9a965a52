/// Where a view saw a face on one side of a place only: the mean over what it saw there is not the place's own.
#pragma once

#include "fit/refine/all_points.h"

namespace partscribe::fit {

/// Per node, mm along the normal: how far the mean over the neighbours of the same view and face lies off the surface,
/// if that view saw the face on one side of the node only. `variance` (mm^2, per axis as the view sees it) is that of
/// the pixels in the mean. It is one-sided beside a step or a silhouette, which need not be an edge of this face: the
/// shadow of another face may end in the middle of it. 0 where views or rays are unknown, and where there are
/// neighbours all around.
std::vector<double> one_sided_mean(const AllPoints& all, double variance, int threads);

}  // namespace partscribe::fit
