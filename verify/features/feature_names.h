/// Names for the features of a mesh, and their order.
#pragma once

#include "verify/features/features.h"

namespace partscribe::verify {

/// Sorts the features and names them: planes first, then holes, bosses and so on, within each kind the larger first,
/// and equal ones by their position. Planes are named by direction and position ("face +z at 10"), all others by kind
/// and number ("hole 2"). Facets too small to be recognised have one entry, which says how many there are.
void name_features(std::vector<MeshFeature>& features);

}  // namespace partscribe::verify
