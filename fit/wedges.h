/// Wedges: blocks of which one side leans.
#pragma once

#include <vector>

#include "fit/candidate.h"
#include "fit/convex_body.h"

namespace partscribe {

/// The wedges in the frames of scanned plane faces that explain most points, refined on a few: one with a top and one without.
/// Where the leaning side was not seen they say what a block may be as well.
std::vector<Candidate> propose_wedges(const std::vector<ConvexFace>& scanned, const FitInput& input, Context& context);

}  // namespace partscribe
