#include "fit/evidence/coverage.h"

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "core/parallel.h"
#include "core/random.h"
#include "fit/refine/refine.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/points/kd_tree.h"
#include "model/distance/distance.h"

namespace partscribe::fit {

Coverage coverage_of(const Candidate& candidate, const FitInput& input, Context& context) {
  constexpr std::size_t samples = 6000;
  const ModelDistance distance(bare_model(candidate));
  const Pose part_from_scan = candidate.scan_from_part.inverse();
  const KdTree tree(input.cloud.points);
  const double size = input.bounds.diagonal();
  const double reach = 4 * input.thin_spacing + input.tolerance;
  std::optional<MeshDistance> source;
  if (input.closed) source.emplace(input.scan->mesh);
  // A wall or a slot thinner than the noise lets half of the points lie on either side and so fits noise; so does a
  // sheet that is folded within the noise.
  const double depth = 3 * input.sampling.sigma;
  std::vector<char> seen(samples, 2), off(samples, 0), thin(samples, 0);
  parallel_for(
      samples, context.threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          Random random(0x5eed0000ull + i);
          Vec3 p;
          for (int k = 0; k < 3; ++k)
            p[k] = input.bounds.center()[k] + (random.uniform() - 0.5) * 1.2 * input.bounds.size()[k];
          double d = 0;
          Vec3 outward = Vec3::Zero();
          for (int step = 0; step < 12; ++step) {
            const Vec3 q = part_from_scan * p;
            d = distance.bound(q);
            if (std::abs(d) < 1e-6 * size) break;
            const double h = 1e-6 * size;
            Vec3 g;
            for (int k = 0; k < 3; ++k)
              g[k] = (distance.bound(q + Vec3::Unit(k) * h) - distance.bound(q - Vec3::Unit(k) * h)) / (2 * h);
            if (!(g.norm() > 1e-6)) break;
            outward = g.normalized();
            p -= candidate.scan_from_part.rotation * (outward * d);
          }
          // It did not reach the surface, or a face that others hide.
          if (std::abs(d) > 1e-3 * size || std::abs(distance(part_from_scan * p).distance) > 1e-3 * size) continue;
          seen[i] = std::sqrt(tree.nearest_one(p).sq_distance) < reach;
          // An edge is thin everywhere, and no wall.
          const Vec3 q = part_from_scan * p,
                     along = outward.norm() > 0 ? Vec3(outward.unitOrthogonal()) : Vec3(Vec3::Zero());
          const Vec3 across = outward.cross(along);
          const auto smooth_over = [&](double step) {
            bool smooth = true;
            for (const Vec3& t : {along, across})
              for (const double side : {step, -step}) smooth &= std::abs(distance(q + side * t).distance) < 0.3 * step;
            return smooth;
          };
          const auto other_side_within = [&] {
            for (const double share : {1.0, 0.75, 0.5, 0.25})
              if (distance(q - share * depth * outward).distance > 0 ||
                  distance(q + share * depth * outward).distance < 0)
                return true;
            return false;
          };
          thin[i] = depth > 0 && seen[i] && smooth_over(depth) && other_side_within();
          // A fit to facets draws a thin edge out by more than they are deep.
          off[i] = source && !source->closest_within(p, input.tolerance) && smooth_over(input.tolerance);
        }
      },
      64);
  double good = 0, bad = 0, slim = 0, all = 0;
  for (std::size_t i = 0; i < samples; ++i) good += seen[i] == 1, bad += off[i], slim += thin[i], all += seen[i] != 2;
  return all > 0 ? Coverage{good / all, bad / all, good > 0 ? slim / good : 0} : Coverage{};
}

}  // namespace partscribe::fit
