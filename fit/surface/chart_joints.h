/// Surfaces of neighbouring charts drawn together along their borders.
#pragma once

#include <vector>

#include "core/context.h"
#include "fit/candidate.h"
#include "fit/surface/chart_pieces.h"
#include "fit/surface/charts.h"
#include "geometry/surfaces/trimmed_surface.h"

namespace partscribe::fit {

/// The pieces, one for each chart of `mesh`, as trimmed surfaces with common edges, numbered from 1 in the order of the
/// charts' borders. An edge is where the two surfaces cross, or lies between them; they are fitted again to meet there,
/// with nearly one tangent plane except along creases. Nothing where they do not come near each other.
std::vector<TrimmedSurface> joined(const TriangleMesh& mesh, const Charts& charts, std::vector<ChartPiece> pieces,
                                   const FitInput& input, Context& context);

}  // namespace partscribe::fit
