/// A superellipsoid as published in 1993: Levenberg and Marquardt on the residuals of equation (6).
///
/// Koivunen, Vezien and Bajcsy, section 3.3, after Solina and Bajcsy 1990. recover_superellipsoid() minimises distances
/// in a mixture instead: (6) has no place for outliers, and of bodies that explain the points about as well it takes
/// the one of least volume, for its residuals carry the factor sqrt(a1 a2 a3).
#pragma once

#include <vector>

#include "core/result.h"
#include "model/solids.h"

namespace partscribe::fit {

struct PublishedSuperellipsoidOptions {
  bool taper = false;  ///< whether the "additional parameters for global deformations" are fitted too
  int steps = 200;     ///< at most, from each start
};

struct PublishedSuperellipsoid {
  SuperellipsoidOf<double> shape;  ///< mm
  Pose scan_from_shape;
  double objective = 0;    ///< (6): sum of a1 a2 a3 (F - 1)^2, mm^3
  double gof = 0;          ///< sqrt(a1 a2 a3) mean |F - 1|, of points divided by their rms radius
  int steps = 0;           ///< that were taken
  bool converged = false;  ///< no step that was worth taking was left
};

/// The sum of (6) for a body at a place; mm^3.
double equation_six(const SuperellipsoidOf<double>& shape, const Pose& scan_from_shape,
                    const std::vector<Vec3>& points);

/// 0.1 <= e1, e2 <= 2. Starts from an ellipsoid about the points' centre of gravity along their principal axes, each of
/// which is z in turn; the least (6) counts. Fails below 20 points, and where these lie in a plane.
Result<PublishedSuperellipsoid> published_superellipsoid(const std::vector<Vec3>& points,
                                                         const PublishedSuperellipsoidOptions& options);

}  // namespace partscribe::fit
