/// How exactly poses can be known from surfaces at all.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "scan/register/register_surface.h"

namespace partscribe::testing {

using namespace scan;

/// Covariance of all poses that no unbiased estimate from what was measured of the surface beats (Cramer & Rao), at the
/// true poses `world_from_view`. Of each view rotation vector times `size` (mm) and shift at `center`, in the world;
/// the surface is not known, only that it is smooth: views that share a place say where they stand to each other, along
/// its normal. `free` (a column each, of all views): what is not to be known; that all move alike never is. Borders,
/// which speak as well, are left out.
///
/// Of a place with normal n that views v see with w_v = points per area / sigma^2, the information is sum w_v d_v d_v'
/// less the same of their mean, with d_v = [(p - center) x n / size, n] in the rows of view v.
Eigen::MatrixXd pose_bound(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& world_from_view,
                           const Vec3& center, double size, const Eigen::MatrixXd& free);

/// 0 of none.
double root_mean_square(const std::vector<double>& values);

}  // namespace partscribe::testing
