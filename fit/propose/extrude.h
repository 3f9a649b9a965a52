/// Proposes extrusions: direction from the normals, outline with its holes as lines and arcs.
#pragma once

#include <vector>

#include "fit/candidate.h"

namespace partscribe::fit {

/// Candidates of increasing detail: box and wedge where the outline is one of theirs, Extrude otherwise.
/// `clear_only`: only outlines that the walls show; none is put together where they show none.
std::vector<Candidate> propose_extrudes(const FitInput& input, const std::vector<Vec3>& start_directions,
                                        bool clear_only, Context& context);

}  // namespace partscribe::fit
