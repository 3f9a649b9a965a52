/// A closed mesh of which it is known what surfaces its triangles stand for.
#pragma once

#include <optional>

#include "core/context.h"
#include "geometry/mesh/triangle_mesh.h"
#include "model/shapes.h"

namespace partscribe::fit {

struct FacedMesh {
  TriangleMesh mesh;           ///< triangles in the order of the faces
  std::vector<TriFace> faces;  ///< "plane 1", "cylinder 2", ...: larger ones first; free form as the rest
};

/// Nothing if the mesh is open or mostly free form. The borders of the faces stay as they are; inside of them triangles
/// are taken out as long as what is left lies within `max_error` (mm).
std::optional<FacedMesh> faced_mesh(const TriangleMesh& mesh, double tolerance, double max_error, Context& context);

}  // namespace partscribe::fit
