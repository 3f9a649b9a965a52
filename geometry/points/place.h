/// Which coordinates are places, and which are damage.
#pragma once

#include <cmath>

#include "geometry/vec.h"

namespace partscribe::geometry {

/// mm; farther out nobody can compute squares of distances of 1e-6 mm.
inline constexpr double farthest_place = 1e15;

inline bool is_place(const Vec3& p) {
  return std::abs(p.x()) < farthest_place && std::abs(p.y()) < farthest_place && std::abs(p.z()) < farthest_place;
}

}  // namespace partscribe::geometry
