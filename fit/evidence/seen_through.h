/// Points that a body would have hidden from the sensor.
#pragma once

#include "fit/candidate.h"

namespace partscribe::fit {

/// Share of the points on its surface (within three sigmas, or half of the tolerance) that the sensor could have seen
/// only through the body: on the way to them, within twenty sigmas before the point, their viewing rays are deeper in
/// it than noise, or the tolerance, puts a point. A face that looks away from the sensor has such points, whatever lies
/// on it. 0 where no rays are known, or no point lies on it.
double share_seen_through(const Candidate& candidate, const FitInput& input, Context& context);

}  // namespace partscribe::fit
