/// The last refinement of what was found among strays, on the points near it as well that were taken for some.
#pragma once

#include "fit/candidate.h"
#include "fit/refine.h"

namespace partscribe {

/// Its half axes are told apart by how its slopes fall off; a narrow kernel cuts off noise at a slant.
bool hangs_on_slopes(const Shape& shape);

/// Strays are told from surfaces by local planes. That costs sparse, steep and strongly bent places a part of their points,
/// those farther out first, and draws a fit to the others inwards. An ellipsoid or superellipsoid has its half axes from such
/// slopes: the strays of `input` within five sigmas of it come back, in turns with a quick refinement; then all numbers are
/// refined as by refine(). For other shapes refine() alone: where flat faces or a single radius fix the numbers, what comes
/// back is more mixed pixels than surface.
RefineReport refine_with_strays_near(Candidate& candidate, const FitInput& input, const RefineOptions& options, Context& context);

}  // namespace partscribe
