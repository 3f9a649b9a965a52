#include "fit/coverage.h"

#include <cmath>

#include "core/parallel.h"
#include "core/random.h"
#include "fit/refine.h"
#include "geometry/kd_tree.h"
#include "model/distance.h"

namespace partscribe {

double covered_share(const Candidate& candidate, const FitInput& input, Context& context) {
  constexpr std::size_t samples = 3000;
  const ModelDistance distance(bare_model(candidate));
  const Pose part_from_scan = candidate.scan_from_part.inverse();
  const KdTree tree(input.cloud.points);
  const double size = input.bounds.diagonal();
  const double reach = 4 * input.thin_spacing + input.tolerance;
  std::vector<char> seen(samples, 2);
  parallel_for(
      samples, context.threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          Random random(0x5eed0000ull + i);
          Vec3 p;
          for (int k = 0; k < 3; ++k)
            p[k] = input.bounds.center()[k] + (random.uniform() - 0.5) * 1.2 * input.bounds.size()[k];
          double d = 0;
          for (int step = 0; step < 12; ++step) {
            const Vec3 q = part_from_scan * p;
            d = distance(q).distance;
            if (std::abs(d) < 1e-6 * size) break;
            const double h = 1e-6 * size;
            Vec3 g;
            for (int k = 0; k < 3; ++k)
              g[k] = (distance(q + Vec3::Unit(k) * h).distance - distance(q - Vec3::Unit(k) * h).distance) / (2 * h);
            if (!(g.norm() > 1e-6)) break;
            p -= candidate.scan_from_part.rotation * (g.normalized() * d);
          }
          if (std::abs(d) > 1e-3 * size) continue;  // did not reach the surface
          seen[i] = std::sqrt(tree.nearest_one(p).sq_distance) < reach;
        }
      },
      64);
  double good = 0, all = 0;
  for (const char s : seen) good += s == 1, all += s != 2;
  return all > 0 ? good / all : 0;
}

}  // namespace partscribe
