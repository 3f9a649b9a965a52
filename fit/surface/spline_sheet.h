/// Free form as trimmed B-spline surfaces.
#pragma once

#include <optional>

#include "core/context.h"
#include "fit/candidate.h"
#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::fit {

/// An open surface as trimmed B-spline surfaces, one for each connected piece: `mesh` says where there is surface and
/// how it is laid out, the points of the scan where exactly it lies. A candidate whose shape is a SurfaceSet, all
/// control points in the scan's frame. Nothing for closed meshes, for pieces that cannot be laid out in a plane, and
/// where the tolerance would need so many control points that triangles say it as shortly.
std::optional<Candidate> spline_sheet(const TriangleMesh& mesh, const FitInput& input, Context& context);

}  // namespace partscribe::fit
