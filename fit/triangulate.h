/// The fallback that always works: a triangulation within tolerance of the data, as small as that allows.
#pragma once

#include "core/result.h"
#include "fit/candidate.h"

namespace partscribe {

/// A candidate whose shape is a TriSurface in the scan's frame (scan_from_part is the identity or a plain shift).
/// From a source mesh: cleaned, small holes closed, decimated. From points: reconstructed, then decimated. The result
/// is manifold and consistently oriented; closed if the data bound a solid.
Result<Candidate> triangulate(const FitInput& input, Context& context);

}  // namespace partscribe
