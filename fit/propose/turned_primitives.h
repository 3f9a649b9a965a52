/// Proposes cylinder, cone and torus about a known axis, straight from the points' radii and heights.
#pragma once

#include <vector>

#include "fit/propose/revolve.h"

namespace partscribe::fit {

/// Starts that need no closed profile: the line or the circle in (radius, height) that holds most points, with ends
/// where its points end. Survives outliers and walls of which only pieces were seen. Empty for other parts.
std::vector<Candidate> propose_turned_primitives(const FitInput& input, const Axis& axis);

}  // namespace partscribe::fit
