/// Poses adjusted a last time by places as they were measured.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "scan/register/register_surface.h"

namespace partscribe::scan {

/// What adjust_by_measured starts from. The unknowns are those of JointResult for all views but the first in `views`:
/// rotation vector about `center` times `size`, and shift, mm.
struct AdjustedViews {
  std::vector<std::size_t> views;
  std::vector<std::pair<std::size_t, std::size_t>> pairs;  ///< positions in `views`: from the first into the second
  Vec3 center = Vec3::Zero();
  double size = 1;
  Eigen::MatrixXd fixed;     ///< columns: the directions that may be moved along
  Eigen::MatrixXd border_h;  ///< normal equations of the borders at the poses given
  Eigen::VectorXd border_g;
};

/// Filtered places have little noise. But on a narrow face between two edges, or past the limb of a round one, they are
/// all off by a part of the noise, to a side that depends on the direction of view, and that does not average out over
/// the face. Measured places are off by noise alone. So correspondences are found by filtered places and normals, and
/// the distances between them by measured places; by all of these, because the mean of a window carries no more
/// information than its samples. `poses` (world_from_view, of all surfaces) are changed for `views`.
void adjust_by_measured(const std::vector<ViewSurface>& surfaces, const AdjustedViews& adjusted,
                        std::vector<Pose>& poses, Context& context);

}  // namespace partscribe::scan
