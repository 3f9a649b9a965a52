/// The last refinement of a candidate, with the points near it that had been taken for outliers.
#pragma once

#include "fit/candidate.h"
#include "fit/refine/refine.h"

namespace partscribe::fit {

/// True for shapes whose half axes are determined by how the surface curves away at its sides; a narrow kernel
/// truncates noise unevenly there.
bool axes_from_slopes(const Shape& shape);

/// Outliers are recognised by local planes. That costs the surface some of its own points on small faces and in sparse,
/// steep and strongly curved places, the outer points first, which biases a fit inwards. Therefore points that were set
/// aside near the candidate are used again, alternating with a quick refinement; then all numbers are refined as by
/// refine().
/// - With few outliers, all points within eight sigmas are used, and the last steps weight each by the probability that
///   it belongs to the surface.
/// - With more than a tenth of outliers, only ellipsoids and superellipsoids get points back, those within five sigmas,
///   because their half axes depend on the sides. Other shapes are determined by flat faces or by a single radius, and
///   most of the points beside those are mixed pixels.
RefineReport refine_with_outliers_near(Candidate& candidate, const FitInput& input, const RefineOptions& options,
                                       Context& context);

}  // namespace partscribe::fit
