#include "fit/uncertainty/slant.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace partscribe::fit {

Deviation slant_deviation(const Candidate& candidate, const AllPoints& all, const ModelDistance& distance,
                          int threads) {
  constexpr double one_sided = 0.3;     // length of the mean normal; 0 all around, 1/2 for half a ball
  constexpr double least_cosine = 0.3;  // of the incidence; beyond, little returns
  Deviation result(all.nodes.size(), 0);
  if (!all.rays.empty()) return result;
  Vec3 sum = Vec3::Zero();
  double count = 0;
  for (std::size_t k = 0; k < all.nodes.size(); ++k) {
    const double length = all.jacobian.gradients[k].norm(), n = double(all.nodes[k].end - all.nodes[k].begin);
    if (length > 0.5) sum += n * all.jacobian.gradients[k] / length, count += n;
  }
  if (!(sum.norm() > one_sided * count)) return result;
  const Vec3 towards = sum.normalized();
  const Pose part_from_scan = candidate.scan_from_part.inverse();
  parallel_for(all.nodes.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const double length = all.jacobian.gradients[k].norm();
      if (!(length > 0.5)) continue;
      const Vec3 normal = all.jacobian.gradients[k] / length;
      const double cosine = std::max(normal.dot(towards), least_cosine);
      const Vec3 across = towards - normal * normal.dot(towards);
      if (!(across.norm() > 1e-9)) continue;
      const Vec3 step = all.sigma[all.nodes[k].begin] * std::sqrt(1 - cosine * cosine) / cosine * across.normalized();
      const Vec3 foot = all.nodes[k].place - distance(part_from_scan * all.nodes[k].place).distance * normal;
      const ModelHit one = distance(part_from_scan * (foot + step)), two = distance(part_from_scan * (foot - step));
      const int face = all.at.face[all.nodes[k].begin];
      if (one.face == face && two.face == face) result[k] = 0.5 * (one.distance + two.distance);
    }
  });
  return result;
}

}  // namespace partscribe::fit
