/// Pieces of one surface put together, and kinds corrected once all of a face is known.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/segment/grow_faces.h"

namespace partscribe::geometry {

/// Unites neighbours that one surface of any kind explains in fewer words (gain_of), best pairs first, and gives single
/// faces the kind that explains them best. `label`: the face of each sample, renumbered. True if anything changed.
bool merge_faces(const FaceSamples& samples, std::vector<GrownFace>& faces, std::vector<std::uint32_t>& label,
                 int threads);

}  // namespace partscribe::geometry
