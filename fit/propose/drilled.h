/// Proposes bodies with round holes drilled into them: the body from what the holes leave, each hole a step of its own.
#pragma once

#include <vector>

#include "fit/propose/best_bodies.h"
#include "geometry/segment/faces.h"

namespace partscribe::fit {

/// The holes are found among `faces`, those of the scan. `bodies` is asked for what the points outside of them show;
/// every body that comes within the tolerance of those is drilled. Equal holes share their sizes; on a circle or in a
/// row they are a pattern. Nothing where there are no holes.
std::vector<Candidate> propose_drilled(const FitInput& input, const Faces& faces, const BodyMaker& bodies,
                                       Context& context);

}  // namespace partscribe::fit
