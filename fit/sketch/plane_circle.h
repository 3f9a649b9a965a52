/// Circles through points of a plane.
#pragma once

#include <vector>

#include "geometry/vec.h"

namespace partscribe::fit {

struct PlaneCircle {
  Vec2 center = Vec2::Zero();
  double radius = 0;
};

/// Orthogonal least squares by Gauss-Newton from `start`.
PlaneCircle polished(PlaneCircle start, const std::vector<Vec2>& on);

}  // namespace partscribe::fit
