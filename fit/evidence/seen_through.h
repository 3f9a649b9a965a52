/// Points that a body would have hidden from the sensor.
#pragma once

#include "fit/candidate.h"

namespace partscribe::fit {

/// Of the points on the surface of the candidate (within three sigmas, or half of the tolerance), the share that the
/// sensor could have seen only through its body: within the last twenty sigmas before the point, the viewing ray runs
/// deeper inside the body than noise, or the tolerance, explains. Whatever points lie on a face that looks away from
/// the sensor are of this kind. 0 where no rays are known, or no point lies on the surface.
double share_seen_through(const Candidate& candidate, const FitInput& input, Context& context);

}  // namespace partscribe::fit
