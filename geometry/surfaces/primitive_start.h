/// Where a primitive fit may begin: charts guessed from a few points by linear fits.
#pragma once

#include <vector>

#include "geometry/surfaces/primitive_kernels.h"

namespace partscribe::geometry {

/// The same primitive with its chart's origin at the surface point nearest to the origin of the points.
PrimitiveChart recentered(PrimitiveChart chart);

/// A chart for a surface with `normal` through `place`, with an axis across it and a curvature.
PrimitiveChart surface_chart(ChartKind kind, const Vec3& place, const Vec3& normal, const Vec3& axis, double kappa,
                             double psi);

/// Guesses in no order of merit, from a few hundred points about the origin of size 1; `normals` may be empty.
std::vector<PrimitiveChart> start_charts(ChartKind kind, const std::vector<Vec3>& points,
                                         const std::vector<Vec3>& normals);

}  // namespace partscribe::geometry
