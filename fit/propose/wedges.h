/// Wedges: blocks of which one side leans.
#pragma once

#include <vector>

#include "fit/candidate.h"
#include "fit/propose/convex_body.h"

namespace partscribe::fit {

/// The wedges in the frames of scanned plane faces that explain most points, refined on a few: one with a top and one
/// without. Where the leaning side was not seen they say what a block may be as well. `ends` are sides that were put
/// where the data end: the likeliest of them as the leaning side make wedges too.
std::vector<Candidate> propose_wedges(const std::vector<ConvexFace>& scanned, const std::vector<ConvexFace>& ends,
                                      const FitInput& input, Context& context);

}  // namespace partscribe::fit
