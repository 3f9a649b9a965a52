/// How much of a candidate's surface the data saw.
#pragma once

#include "fit/candidate.h"

namespace partscribe {

/// Share of places on the surface with data nearby: random places in the bounding box are drawn onto the surface along
/// the distance gradient.
double covered_share(const Candidate& candidate, const FitInput& input, Context& context);

}  // namespace partscribe
