/// Poses of one view against another from the planes that both saw: what parts with few features have.
#pragma once

#include <vector>

#include "scan/register/register_pair.h"

namespace partscribe::scan {

/// n . x = offset in the view's frame.
struct ViewPlane {
  Vec3 normal = Vec3::Zero();  ///< unit, towards the sensor
  double offset = 0;           ///< mm
  double share = 0;            ///< of the view's smooth points that lie on it
};

/// The largest first; faces in one plane are one. Round surfaces give narrow strips.
std::vector<ViewPlane> planes_of(const ViewSurface& surface, std::size_t most);

/// Candidates for target_from_source, the best first, each place once: two planes of one view laid onto two of the
/// other that meet under the same angle turn it; parallel ones shift it. Along what they leave free its ends or its
/// middle are laid onto those of the other.
std::vector<Pose> plane_poses(const std::vector<ViewPlane>& source_planes, const std::vector<ViewPlane>& target_planes,
                              const std::vector<ViewSurface>& surfaces, std::size_t source, std::size_t target,
                              double reach, std::size_t most);

}  // namespace partscribe::scan
