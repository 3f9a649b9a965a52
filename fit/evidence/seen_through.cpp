#include "fit/evidence/seen_through.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "fit/refine/refine.h"
#include "model/distance/distance.h"

namespace partscribe::fit {

double share_seen_through(const Candidate& candidate, const FitInput& input, Context& context) {
  const auto& cloud = input.cloud;
  constexpr std::size_t most_asked = 6000;
  if (cloud.empty() || cloud.rays.size() != cloud.size()) return 0;
  const std::size_t step = (cloud.size() + most_asked - 1) / most_asked, n = (cloud.size() + step - 1) / step;
  const double sigma = input.sampling.sigma, on = std::max(3 * sigma, 0.5 * input.tolerance),
               deep = std::max(3 * sigma, input.tolerance);
  const ModelDistance distance(bare_model(candidate));
  const Pose part_from_scan = candidate.scan_from_part.inverse();
  enum : char { elsewhere, seen, through };
  std::vector<char> point(n, elsewhere);
  parallel_for(n, context.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 p = part_from_scan * cloud.points[i * step], back = -(part_from_scan.rotation * cloud.rays[i * step]);
      if (back.isZero() || std::abs(distance(p).distance) > on) continue;
      const auto inside = [&](double times) { return distance(p + times * deep * back).distance < -deep; };
      // Near an end of the body the ray is soon out of it again; at a slant it is deep late.
      point[i] = inside(1.5) || inside(3) || inside(7) ? through : seen;
    }
  });
  const double all = double(n) - double(std::count(point.begin(), point.end(), elsewhere));
  return all > 0 ? double(std::count(point.begin(), point.end(), through)) / all : 0;
}

}  // namespace partscribe::fit
