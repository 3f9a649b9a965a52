/// Proposes a sphere and an ellipsoid, or a superellipsoid, for parts that are one of these.
#pragma once

#include <vector>

#include "fit/candidate.h"
#include "fit/propose/superellipsoid.h"

namespace partscribe::fit {

/// Each is proposed only if the median distance of its start says that a refinement could meet the tolerance.
/// Sphere before ellipsoid: fewer numbers first.
std::vector<Candidate> propose_quadrics(const FitInput& input, const SuperellipsoidFit& hypothesis, Context& context);

/// The hypothesis as a description, under the same condition.
std::vector<Candidate> propose_superellipsoids(const FitInput& input, const SuperellipsoidFit& hypothesis);

}  // namespace partscribe::fit
