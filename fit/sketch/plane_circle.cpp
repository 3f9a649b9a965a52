#include "fit/sketch/plane_circle.h"

#include "geometry/least_squares.h"

namespace partscribe::fit {

PlaneCircle polished(PlaneCircle c, const std::vector<Vec2>& on) {
  for (int round = 0; round < 10; ++round) {
    NormalSums<3> sums;
    for (const Vec2& p : on) {
      const Vec2 d = p - c.center;
      const double r = d.norm();
      if (!(r > 0)) continue;
      sums.add(Vec3(d.x() / r, d.y() / r, 1), r - c.radius);
    }
    const Vec3 step = sums.solution(1e-9);
    if (!step.allFinite() || step.norm() > c.radius) break;
    c.center += step.head<2>(), c.radius += step.z();
  }
  return c;
}

}  // namespace partscribe::fit
