/// Proposes extrusions: direction from the normals, outline with its holes as lines and arcs.
#pragma once

#include <vector>

#include "fit/candidate.h"

namespace partscribe::fit {

/// Candidates of increasing detail: box and wedge where the outline is one of theirs, Extrude otherwise.
std::vector<Candidate> propose_extrudes(const FitInput& input, const std::vector<Vec3>& start_directions,
                                        Context& context);

}  // namespace partscribe::fit
