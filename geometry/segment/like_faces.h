/// Cylinders like those that were found, in places where too few points lie to find one that nothing is known of: the
/// holes of a pattern are as wide as each other and run alike, so that only the place of their axis is asked for.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/points/point_cloud.h"
#include "geometry/segment/grow_faces.h"

namespace partscribe::geometry {

struct LikeFace {
  GrownFace face;                      ///< without members
  std::vector<std::uint32_t> members;  ///< points of the cloud, ascending
};

/// Among points that belong to no face and are not left out, with normals out of the material. `label`: the face of
/// each point, or no_face. `least_sigma`, `pitch`: mm, a floor of the noise and how far samples of the cloud are apart.
/// Only of cylinders of which two thirds of the turn were seen, and only such.
std::vector<LikeFace> like_faces(const PointCloud& cloud, const std::vector<std::uint8_t>& left_out,
                                 const std::vector<std::uint32_t>& label, const std::vector<GrownFace>& found,
                                 double least_sigma, double pitch);

}  // namespace partscribe::geometry
