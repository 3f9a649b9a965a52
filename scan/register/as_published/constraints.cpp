#include "scan/register/as_published/constraints.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/statistics.h"

namespace partscribe::scan {

std::vector<std::uint8_t> visible_points(const std::vector<ReferencePoint>& points, const Pose& first_estimate,
                                         const std::vector<PlacedView>& placed, double margin) {
  constexpr double steepest = 0.5;  // cosine between ray and normal
  std::vector<std::uint8_t> visible(points.size(), 0);
  for (const PlacedView& view : placed) {
    const Pose there = view.world_from_view.inverse() * first_estimate;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3 p = there * points[i].place;
      if ((there.rotation * points[i].normal).dot(view.surface->raster.ray(p)) < -steepest &&
          sight(view.surface->raster, p, margin) == Sight::measured)
        visible[i] = 1;
    }
  }
  return visible;
}

double mismatch_limit(const std::vector<double>& residuals, double deviations) {
  if (residuals.empty() || std::isinf(deviations)) return std::numeric_limits<double>::infinity();
  constexpr double gaussian = 0.5244;  // standard deviations that `least_overlap` of all sizes are below
  return deviations / gaussian * quantile(residuals, least_overlap);
}

bool normals_consistent(const PointMatch& match, const StateVector& q, double alpha) {
  return match.n_x.dot(rotation_matrix(q) * match.n_p) > std::cos(alpha);
}

ConsistentState consistent_state(const std::vector<PointMatch>& matches, double alpha) {
  ConsistentState result;
  result.valid.assign(matches.size(), 1);
  for (bool violated = true; violated;) {
    std::vector<Vec3> p, x;
    for (std::size_t i = 0; i < matches.size(); ++i)
      if (result.valid[i]) p.push_back(matches[i].p), x.push_back(matches[i].x);
    result.count = p.size();
    if (result.count < 3) {
      result.state = {};
      break;
    }
    result.state = best_state(p, x), ++result.solved;
    violated = false;
    for (std::size_t i = 0; i < matches.size(); ++i)
      if (result.valid[i] && !normals_consistent(matches[i], result.state, alpha)) result.valid[i] = 0, violated = true;
  }
  return result;
}

}  // namespace partscribe::scan
