/// Wedges: blocks of which one side leans.
#pragma once

#include <vector>

#include "fit/candidate.h"
#include "fit/propose/convex_body.h"

namespace partscribe::fit {

/// The two wedges, one with a top face and one without, that explain most points in the frames of scanned plane faces,
/// refined on a few of them. Where the inclined side was not seen they are alternatives to a block. `ends` are sides
/// that were placed where the data end: wedges with the likeliest of these as the inclined side are added.
std::vector<Candidate> propose_wedges(const std::vector<ConvexFace>& scanned, const std::vector<ConvexFace>& ends,
                                      const FitInput& input, Context& context);

}  // namespace partscribe::fit
