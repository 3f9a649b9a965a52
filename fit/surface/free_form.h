/// Free form as trimmed B-spline surfaces.
#pragma once

#include <optional>

#include "core/context.h"
#include "fit/candidate.h"
#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::fit {

/// A surface as trimmed B-spline surfaces: one for each connected piece that can be laid out in a plane, several that
/// meet along common edges for one that cannot, or that is closed. `mesh` says where there is surface, the points of
/// the scan where exactly it lies. A candidate whose shape is a SurfaceSet, all control points in the scan's frame.
/// Nothing where the tolerance would need so many control points that triangles say it as shortly.
std::optional<Candidate> free_form(const TriangleMesh& mesh, const FitInput& input, Context& context);

/// A height map (height_map_of) as one surface over its whole rectangle. Nothing for any other scan.
std::optional<Candidate> free_form_of_map(const FitInput& input, Context& context);

}  // namespace partscribe::fit
