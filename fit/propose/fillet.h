/// Proposes a fillet: two legs at a right angle and a concave quarter of a circle or ellipse between their ends.
#pragma once

#include <vector>

#include "fit/candidate.h"

namespace partscribe::fit {

/// At most two candidates, the round one (equal legs) first, if a start lies near the data.
std::vector<Candidate> propose_fillets(const FitInput& input, Context& context);

}  // namespace partscribe::fit
