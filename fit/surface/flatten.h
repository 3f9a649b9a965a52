/// An open mesh laid out in a plane, so that distances change little.
#pragma once

#include <optional>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::fit {

/// Where each vertex goes, mm; triangles keep their sense of rotation. Along one direction, if none of the surface is
/// steeper than some 65 degrees seen from there; else as rigidly as possible. Nothing for meshes that are no disc with
/// or without holes, and where triangles would turn over.
std::optional<std::vector<Vec2>> flattened(const TriangleMesh& mesh);

/// Closed loops of border vertices, each as its triangles run through it; the surface lies to their left.
std::vector<std::vector<std::uint32_t>> border_loops(const TriangleMesh& mesh);

}  // namespace partscribe::fit
