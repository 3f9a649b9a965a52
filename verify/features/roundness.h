/// Whether the scan is round where the artifact has flat walls.
#pragma once

#include "geometry/mesh/mesh_distance.h"
#include "geometry/surfaces/primitive_fit.h"
#include "verify/compare/source.h"

namespace partscribe::verify {

/// True if the scanned wall between `low` and `high` along the cylinder's axis, about as far from it as its radius, is
/// round: a cylinder through its points fits them clearly better than the artifact does, and as well as noise allows.
/// The wall of a square or hexagonal hole of another size is not round.
bool scanned_round(const ScanSource& source, const MeshDistance& artifact, const Primitive& cylinder, double low,
                   double high);

}  // namespace partscribe::verify
