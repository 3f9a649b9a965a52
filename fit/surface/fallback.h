/// What is written where no procedure describes a scan.
#pragma once

#include "core/result.h"
#include "fit/evidence/evidence.h"

namespace partscribe::fit {

struct Fallback {
  Candidate mesh;
  CandidateEvidence evidence;  ///< of up to 400,000 points
};

/// The smallest triangulation that lies safely within the tolerance of the scan. It aims at a share of the tolerance;
/// where that was not enough it tries again, finer, as long as the triangles are what is in the way and not the surface
/// that they follow. `input` is of a scan.
Result<Fallback> fallback_of(const FitInput& input, Context& context);

}  // namespace partscribe::fit
