/// A torus as a candidate, and a proposal of one for a piece that is too small to tell its axis by its normals.
#pragma once

#include <vector>

#include "fit/candidate.h"

namespace partscribe::fit {

/// A torus about the z axis of its own frame; lengths in mm.
Candidate torus_candidate(double major_radius, double minor_radius, const Pose& scan_from_part);

/// By orthogonal distance from the points themselves (geometry/surfaces/primitive_fit.h); at most one. Nothing for
/// points that leave the ring or its tube open, or of which less than two thirds lie near it.
std::vector<Candidate> propose_torus_piece(const FitInput& input);

}  // namespace partscribe::fit
