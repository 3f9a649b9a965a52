/// The coarse mesh of a known part, as programs export it for a printer.
#pragma once

#include "geometry/mesh/triangle_mesh.h"
#include "model/model.h"

namespace partscribe::testing::recovery {

using namespace model;

/// Closed, in the part's own frame, all corners on the true surface: `around` facets to the full turn of whatever is
/// round, two triangles to a flat rectangle.
TriangleMesh coarse_mesh(const Model& truth, int around);

/// mm: how far the facets reach away from the true surface at most.
double sagitta_of(const TriangleMesh& mesh, const Model& truth);

/// What is left when the triangles that face `towards` least are gone, `share` of the area.
TriangleMesh without_far_side(const TriangleMesh& mesh, const Vec3& towards, double share);

}  // namespace partscribe::testing::recovery
