/// Which triangles of a mesh lie beside each other.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::geometry {

inline constexpr std::uint32_t no_neighbour = ~0u;

/// For each triangle the ones beyond its edges, the edge from corner k to the next at place k; no_neighbour where there
/// is none that runs through the edge the other way.
std::vector<std::array<std::uint32_t, 3>> mesh_neighbours(const TriangleMesh& mesh);

}  // namespace partscribe::geometry
