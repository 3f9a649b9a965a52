/// A closed or folded surface as several B-spline surfaces that meet along common edges.
#pragma once

#include <vector>

#include "core/context.h"
#include "fit/candidate.h"
#include "geometry/mesh/triangle_mesh.h"
#include "geometry/surfaces/trimmed_surface.h"

namespace partscribe::fit {

/// One surface for each chart of a connected mesh (charts_of); edges are numbered from 1, those of the mesh's border
/// have one side. Each surface is fitted to the points of its chart and of a strip beyond it; then neighbours are drawn
/// to their mean along the edge and beside it, so that they meet there with nearly one tangent plane, except along
/// creases. Charts that would take too many control points are cut in two. Nothing where that does not help.
std::vector<TrimmedSurface> spline_charts(const TriangleMesh& mesh, const FitInput& input, Context& context);

}  // namespace partscribe::fit
