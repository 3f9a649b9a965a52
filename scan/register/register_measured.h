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

/// Filtered places are quiet, but on a narrow face between two edges, or past the limb of a round one, all of them lie
/// off by a part of the noise, to a side that depends on how the face was seen, and that does not average out over the
/// face as noise does. Measured places are off by noise alone. So partners are found by filtered places and normals,
/// and held against each other by measured places: all of them, for a window's mean says no more than its samples.
/// `poses` (world_from_view, of all surfaces) are changed for `views`.
void adjust_by_measured(const std::vector<ViewSurface>& surfaces, const AdjustedViews& adjusted,
                        std::vector<Pose>& poses, Context& context);

}  // namespace partscribe::scan
