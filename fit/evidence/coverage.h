/// How much of a candidate's surface the data saw.
#pragma once

#include "fit/candidate.h"

namespace partscribe::fit {

struct Coverage {
  double covered = 0;       ///< share of places on the surface with data nearby
  double contradicted = 0;  ///< share that is farther than the tolerance from a closed source mesh
  double thin = 0;          ///< share, of places with data nearby, whose opposite side is nearer than noise can tell
};

/// What of a surface may be contradicted without its being wrong: random places miss a little.
inline constexpr double most_contradicted = 0.001;

/// Random places in the bounding box are drawn onto the surface along the distance gradient.
Coverage coverage_of(const Candidate& candidate, const FitInput& input, Context& context);

}  // namespace partscribe::fit
