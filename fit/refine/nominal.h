/// Which round size a measured one was meant to be: metric and inch series, preferred numbers, drills and threads.
#pragma once

#include <optional>
#include <vector>

#include "model/model.h"

namespace partscribe::fit {

/// One answer per parameter, nothing where no series comes near: the candidate, its z, its series, its probability, and
/// whether it is kept.
///
/// A parameter is either arbitrary (any value nearby as likely as any other) or meant to be a value of one of the
/// series. For a series whose values lie g apart here the ratio of the two likelihoods is g / (sqrt(2 pi) sigma)
/// exp(-z^2 / 2). All parameters of a part share two unknowns, integrated out: its designer's habit (metric or inch,
/// and the step that most sizes are multiples of) and the share of its sizes that are nominal. So a part full of round
/// sizes is believed its next one, and a worn part, whose sizes miss every series by many sigmas, is not believed the
/// one that chance puts on a fine grid. Kept: probability of at least 0.9, |z| <= 2.6, and a shift within a quarter of
/// the tolerance; `size` (mm) is the lever of an angle. Radii are also read as diameters; those of holes also as
/// drills, clearance and tap holes. Parameters without sigma, counts and ratios get no answer.
std::vector<std::optional<NominalEvidence>> nominal_values(const std::vector<Parameter>& parameters, double tolerance,
                                                           double size);

}  // namespace partscribe::fit
