/// Which matches count in the registration of 1993: what is visible, near enough, and faces the same way
/// (section 2.1.2).
#pragma once

#include <cstdint>
#include <vector>

#include "scan/register/as_published/primitives.h"
#include "scan/register/as_published/state_vector.h"

namespace partscribe::scan {

/// A view that is part of the model, at its registered pose.
struct PlacedView {
  const ViewSurface* surface = nullptr;
  Pose world_from_view;
};

/// 1 for each point that by the first estimate of its view's pose at least one placed view can see: it lies in its
/// image, faces it (within 60 degrees: what is seen at a slant may be hidden as well by a rough estimate, and sensors
/// return little of it), and is neither behind nor before what was measured there by more than `margin` (mm, for the
/// estimate is a rough one).
std::vector<std::uint8_t> visible_points(const std::vector<ReferencePoint>& points, const Pose& first_estimate,
                                         const std::vector<PlacedView>& placed, double margin);

/// The share of matched points that has to overlap: what mismatch_limit takes for sound.
inline constexpr double least_overlap = 0.4;

/// From which size on a residual |x - R p - q_T| is that of a mismatch, mm: what the distribution of all residuals says
/// under the state of the previous iteration. Overlapping points leave small residuals, mismatched points large ones.
/// So the smallest `least_overlap` of them tell the standard deviation, as those of a Gaussian's sizes would, and the
/// limit is `deviations` of it. Infinite for infinite `deviations`.
double mismatch_limit(const std::vector<double>& residuals, double deviations);

/// p_i where it is now, what it is matched with, and both normals; all in the world.
struct PointMatch {
  Vec3 p, x, n_p, n_x;
};

/// n_x . R(q_R) n_p > cos(alpha).
bool normals_consistent(const PointMatch& match, const StateVector& q, double alpha);

/// The displacement of one iteration.
struct ConsistentState {
  StateVector state;
  std::vector<std::uint8_t> valid;  ///< 1 for each match that no displacement violated
  std::size_t count = 0;            ///< of these
  int solved = 0;                   ///< how often the displacement was computed
};

/// The displacement is recomputed until no match violates the consistency of normals: each one turns the points, and
/// those that violate it then are left out of the next. Fewer than three matches leave the points where they are.
ConsistentState consistent_state(const std::vector<PointMatch>& matches, double alpha);

}  // namespace partscribe::scan
