/// Recovers one superellipsoid from unorganised, noisy, partial points: the hypothesis that orders the procedures.
#pragma once

#include "fit/candidate.h"

namespace partscribe::fit {

/// A recovered superellipsoid and where it stands.
struct SuperellipsoidFit {
  SuperellipsoidOf<double> shape;
  Pose scan_from_shape;
  Hypothesis hypothesis;    ///< includes GOF on unit-scaled data, GOF in mm and what it suggests
  double inlier_share = 0;  ///< of the Gaussian-uniform mixture
};

/// Equations (5), (6) of the 1993 paper, with 0.1..2 as bounds of e1 and e2, linear taper and several starts. Robust
/// against outliers by a Gaussian-uniform mixture with annealed sigma (Liu 2022). Uses at most some 1500 points.
/// `normals` may be empty or of any sign. Where they keep to three perpendicular directions, these are tried as axes: a
/// body that was seen from one side only has other principal axes.
SuperellipsoidFit recover_superellipsoid(const std::vector<Vec3>& points, Context& context,
                                         const std::vector<Vec3>& normals = {});

/// "sphere", "ellipsoid", "box", "cylinder", "frustum", "wedge", "surface of revolution" or "none".
std::string suggested_procedure(const SuperellipsoidOf<double>& shape, double gof_mm, double size);

}  // namespace partscribe::fit
