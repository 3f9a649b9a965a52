/// Proposes a supertoroid for parts with one hole whose ring or tube is not round.
#pragma once

#include <vector>

#include "fit/candidate.h"

namespace partscribe::fit {

/// At most one candidate, if its start lies near the data, and before it a torus where all of it is nearly round.
/// `directions` of possible axes are tried besides the axis about which the normals turn.
std::vector<Candidate> propose_rings(const FitInput& input, const std::vector<Vec3>& directions, Context& context);

}  // namespace partscribe::fit
