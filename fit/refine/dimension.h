/// Gives a found part the sizes that a drawing of it would have.
#pragma once

#include <optional>

#include "fit/candidate.h"

namespace partscribe::fit {

/// Diameters of full circles in place of their radii (`hole_d`), the width of a bar in place of the radius of its round
/// ends, the distance of its two ends, the thickness of a plate. The shape stays what it is, and what is known of each
/// number (fitted value, sigmas, points) comes along.
void dimension(Candidate& candidate);

/// The candidate with one number in place of several of the same role that are equal, as far as their sigmas tell (3 of
/// their difference, and `within` mm): two holes share `hole_d`. Grooves and bulges of turned parts are told by their
/// diameters. The values are starts, to be refined; none if there is nothing to change.
std::optional<Candidate> related(const Candidate& candidate, double within);

}  // namespace partscribe::fit
