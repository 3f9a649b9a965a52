/// Pieces of the evaluated surface that the scan must have shown, had they been there.
#pragma once

#include "verify/compare/model_to_data.h"

namespace partscribe::verify {

/// Contradicts what sticks out of the part, has no data at all, and lies in plain view: patches of whole faces without
/// data, behind which lies the patch itself, and without which the scanned surface still hangs together. They are in
/// plain view if two views with known lines of sight see a fifth of them at less than 60 degrees, or if a fiftieth of
/// all directions does from which the scanner may have looked, known or not: a pin is thinner than what tells a view
/// that nothing hides it. Those are directions from which nearly everything else in plain view was scanned, and from
/// which scanned surface is seen that leans as far to the patch's side as the patch does: whoever looks from above sees
/// no underside.
void contradict_in_plain_view(const ScanSource& source, const TriangleMesh& mesh, const MeshDistance& surface,
                              const std::vector<Vec3>& normals, double tolerance, SurfaceField& field, int threads);

/// `count` unit vectors, evenly over the sphere.
std::vector<Vec3> even_directions(std::size_t count);

}  // namespace partscribe::verify
