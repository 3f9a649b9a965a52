/// Proposes blocks, wedges and convex polyhedra for parts whose faces are all plane.
#pragma once

#include <vector>

#include "fit/candidate.h"

namespace partscribe::fit {

/// Box, Wedge and HalfSpaces, the simplest first, as far as the faces of the body allow; empty for other parts. A face
/// that was not scanned is placed where the data end, and its parameter's note says so. It is opposite or perpendicular
/// to scanned faces if the data reach the edges that this gives; otherwise it lies where it leaves the scanned faces
/// smallest. It may also be inclined: therefore wedges in the frames of the scanned faces are proposed as well.
std::vector<Candidate> propose_polyhedra(const FitInput& input, Context& context);

}  // namespace partscribe::fit
