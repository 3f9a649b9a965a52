/// What a fit makes of a case that knows which points are outliers, how noisy each other one is, and the truth to start
/// from.
#pragma once

#include <vector>

#include "testing/recovery/cases.h"

namespace partscribe::testing::recovery {

/// The numbers of the truth's own parametrisation by weighted orthogonal distances of the true points. Nothing for a
/// mesh.
std::vector<double> best_numbers(const Case& c);

}  // namespace partscribe::testing::recovery
