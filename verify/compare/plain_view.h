/// Pieces of the evaluated surface that the scan must have shown, had they been there.
#pragma once

#include "verify/compare/model_to_data.h"

namespace partscribe::verify {

/// Marks surface as contradicted that sticks out of the part in plain view and yet has no data at all: a patch of whole
/// faces without data, which has itself on the far side of its material, and without which the scanned surface is still
/// connected (the sides of a plate are needed to connect its top and bottom).
///
/// A patch is in plain view if at least a fifth of it can be seen, at less than 60 degrees from its normal,
/// - by two views with known lines of sight, or
/// - from a fiftieth of all directions, counting only those from which the scanner may have looked: nearly everything
///   else that is in plain view from there was scanned, and so was surface that leans as far to the patch's side as the
///   patch does (from above, nobody sees an underside).
/// The second test is also made where lines of sight are known, because a pin may be too thin for a view's depth map.
void contradict_in_plain_view(const ScanSource& source, const TriangleMesh& mesh, const MeshDistance& surface,
                              const std::vector<Vec3>& normals, double tolerance, SurfaceField& field, int threads);

/// `count` unit vectors, evenly over the sphere.
std::vector<Vec3> even_directions(std::size_t count);

}  // namespace partscribe::verify
