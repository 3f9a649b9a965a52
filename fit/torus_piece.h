/// Proposes a torus for a piece of one that is too small to tell its axis by its normals.
#pragma once

#include <vector>

#include "fit/candidate.h"

namespace partscribe {

/// By orthogonal distance from the points themselves (geometry/primitive_fit.h); at most one. Nothing for points that leave
/// the ring or its tube open, or of which less than two thirds lie near it.
std::vector<Candidate> propose_torus_piece(const FitInput& input);

}  // namespace partscribe
