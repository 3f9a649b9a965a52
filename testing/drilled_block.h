/// A block with holes through it, drawn point by point.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/number.h"
#include "core/random.h"
#include "geometry/vec.h"

namespace partscribe::testing {

using namespace geometry;

/// About the origin; the holes run along z.
struct DrilledBlock {
  Vec3 half;                ///< mm
  std::vector<Vec2> holes;  ///< centres
  double radius = 0;        ///< mm, of every hole

  struct Place {
    Vec3 point, normal;  ///< outward
  };

  /// A fifth of the places on the walls of the holes, the others evenly over the faces.
  Place draw(Random& random) const {
    while (true) {
      if (random.uniform() < 0.2) {
        const Vec2& h = holes[random.below(holes.size())];
        const double angle = random.uniform(0, 2 * pi);
        const Vec3 n(-std::cos(angle), -std::sin(angle), 0);
        return {Vec3(h.x(), h.y(), random.uniform(-half.z(), half.z())) - radius * n, n};
      }
      Vec3 p, n = Vec3::Zero();
      for (int k = 0; k < 3; ++k) p[k] = random.uniform(-half[k], half[k]);
      const double top = half.x() * half.y(), front = half.x() * half.z(), side = half.y() * half.z();
      const double choice = random.uniform() * (top + front + side);
      const int axis = choice < top ? 2 : choice < top + front ? 1 : 0;
      n[axis] = random.uniform() < 0.5 ? -1 : 1;
      p[axis] = half[axis] * n[axis];
      const bool in_hole =
          std::any_of(holes.begin(), holes.end(), [&](const Vec2& h) { return (p.head<2>() - h).norm() < radius; });
      if (axis != 2 || !in_hole) return {p, n};
    }
  }
};

}  // namespace partscribe::testing
