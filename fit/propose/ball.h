/// Balls through points, outliers among them.
#pragma once

#include <vector>

#include "fit/candidate.h"

namespace partscribe::fit {

struct Ball {
  Vec3 centre = Vec3::Zero();
  double radius = 0;
};

/// Reweighted least squares of |p|^2 - 2 c.p = r^2 - |c|^2: the points alone. `unit`: their size.
Ball ball_through(const std::vector<Vec3>& points, const Vec3& origin, double unit);

/// The place nearest to all normal lines (whatever the sense of the normals), reweighted. Normals of no length are
/// unknown.
Ball ball_of_normals(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, const Vec3& origin,
                     double unit);

/// Least squares on |p - c| - r with weights that fall off at `reach` in the end.
void polish_ball(Ball& ball, const std::vector<Vec3>& points, double reach);

}  // namespace partscribe::fit
