/// The last refinement of what was found among strays, on the points near it as well that were taken for some.
#pragma once

#include "fit/candidate.h"
#include "fit/refine/refine.h"

namespace partscribe::fit {

/// Its half axes are told apart by how its slopes fall off; a narrow kernel cuts off noise at a slant.
bool hangs_on_slopes(const Shape& shape);

/// Strays are told from surfaces by local planes. That costs sparse, steep and strongly bent places and small faces a
/// part of their points, those farther out first, and draws a fit to the others inwards. Those of `input` near the
/// candidate come back, in turns with a quick refinement; then all numbers are refined as by refine(). Among few strays
/// all that lie within eight sigmas do, and the last steps give each the odds that it is none of them. Where more than
/// a tenth were strays, only an ellipsoid or superellipsoid has its points back, which has its half axes from such
/// slopes, those within five sigmas: where flat faces or a single radius fix the numbers, what comes back there is more
/// mixed pixels than surface.
RefineReport refine_with_strays_near(Candidate& candidate, const FitInput& input, const RefineOptions& options,
                                     Context& context);

}  // namespace partscribe::fit
