/// Whether a mesh bounds a solid, and if not, why not.
#pragma once

#include <string>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::verify {

/// A mesh with united vertices and what is wrong with it as the boundary of a solid.
struct SolidCheck {
  TriangleMesh mesh;                ///< vertices united, flaps without thickness removed
  bool solid = false;               ///< closed, one orientation, positive volume
  std::vector<std::string> faults;  ///< one line each; empty if and only if `solid`
};

/// Unites equal vertices first and, if that leaves gaps, vertices within a ten-millionth of the size.
SolidCheck check_solid(const TriangleMesh& mesh);

/// The same surface with vertices and triangles in sorted order, for programs whose order varies from run to run.
TriangleMesh in_canonical_order(const TriangleMesh& mesh);

}  // namespace partscribe::verify
