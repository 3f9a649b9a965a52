/// An open surface that can be laid out in a plane as one trimmed B-spline surface.
#pragma once

#include <optional>
#include <vector>

#include "core/context.h"
#include "fit/candidate.h"
#include "geometry/mesh/triangle_mesh.h"
#include "geometry/surfaces/trimmed_surface.h"

namespace partscribe::fit {

/// The surface through the points of the scan that lie near `mesh`, whose vertices go to `places` (mm) of the
/// parameters' plane; its trims, with edges numbered from 1, follow the border of the mesh and hold the points. Nothing
/// where that would take too many control points.
std::optional<TrimmedSurface> spline_sheet(const TriangleMesh& mesh, const std::vector<Vec2>& places,
                                           const FitInput& input, Context& context);

}  // namespace partscribe::fit
