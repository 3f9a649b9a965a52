/// Handles of meshes: found by short loops around them, and cut through.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::geometry {

/// Closed loops of vertices no longer than `longest` mm that do not touch each other and without which the mesh stays
/// as connected as it is, the shortest first: they run around handles, or through them. `mesh` must be manifold and
/// consistently oriented; its border counts as filled, and where that touches itself there are no loops. A mesh with
/// many handles may have more of them when these are cut.
std::vector<std::vector<std::uint32_t>> handle_loops(const TriangleMesh& mesh, double longest);

/// The mesh cut along handle_loops, both sides filled, until there are none of that length. What was surface stays
/// where it is; what is added lies within a quarter of `longest` of it.
TriangleMesh without_handles(TriangleMesh mesh, double longest);

}  // namespace partscribe::geometry
