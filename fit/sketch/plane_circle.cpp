#include "fit/sketch/plane_circle.h"

#include <Eigen/Cholesky>

#include "geometry/decompose.h"

namespace partscribe::fit {

PlaneCircle polished(PlaneCircle c, const std::vector<Vec2>& on) {
  for (int round = 0; round < 10; ++round) {
    Mat3 h = 1e-9 * Mat3::Identity();
    Vec3 g = Vec3::Zero();
    for (const Vec2& p : on) {
      const Vec2 d = p - c.center;
      const double r = d.norm();
      if (!(r > 0)) continue;
      const Vec3 row(-d.x() / r, -d.y() / r, -1);
      h += row * row.transpose(), g += (r - c.radius) * row;
    }
    const Vec3 step = -solve_ldlt(h, g);
    if (!step.allFinite() || step.norm() > c.radius) break;
    c.center += step.head<2>(), c.radius += step.z();
  }
  return c;
}

}  // namespace partscribe::fit
