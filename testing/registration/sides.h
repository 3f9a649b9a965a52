/// Poses of views that were said to fit as well somewhere else, held against the truth.
#pragma once

#include <vector>

#include "scan/register/register.h"

namespace partscribe::testing::registration {

using namespace scan;

/// The pose of every view, of those that were said to fit in several places (Registration::alike) the one with which
/// all together, moved alike, come nearest to the truth. `size`, mm: what a radian weighs. Refused views stay where
/// they are.
std::vector<Pose> best_sides(const std::vector<Pose>& truth, const Registration& registration, double size);

}  // namespace partscribe::testing::registration
