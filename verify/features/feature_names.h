/// Names for the features of a mesh, and their order.
#pragma once

#include "verify/features/features.h"

namespace partscribe::verify {

/// Planes first, then holes, bosses, ..., the larger ones first; of equal ones the place decides. Planes are called by
/// their direction and place ("face +z at 10"), all others by their kind and a number ("hole 2"); what is too small to
/// be recognised is counted: `small_faces`.
void name_features(std::vector<MeshFeature>& features, std::size_t small_faces);

}  // namespace partscribe::verify
