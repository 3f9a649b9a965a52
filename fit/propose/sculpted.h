/// Proposes bodies some of whose faces are free form: a plain body from all other faces, and a B-spline surface for
/// each that cuts it.
#pragma once

#include <vector>

#include "fit/propose/best_bodies.h"
#include "geometry/segment/faces.h"

namespace partscribe::fit {

/// `faces` are those of the scan. What no plane, cylinder or cone of some size describes is free form; each connected
/// piece of it has to be seen from one direction. The piece is covered with a flat lid, `bodies` is asked for what
/// there is then, as stock is before it is milled, and the surface through the piece cuts the lid off. Nothing where
/// there is no such piece, or nothing else, and among many outliers.
std::vector<Candidate> propose_sculpted(const FitInput& input, const Faces& faces, const BodyMaker& bodies,
                                        Context& context);

}  // namespace partscribe::fit
