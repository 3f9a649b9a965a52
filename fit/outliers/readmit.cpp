#include "fit/outliers/readmit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/parallel.h"
#include "geometry/points/keep_points.h"
#include "model/distance/distance.h"

namespace partscribe::fit {
namespace {

// A narrower band would truncate noise unevenly. Where the last steps weight a point by the probability that it is an
// outlier (all_points.h), they estimate it from the points beyond the noise.
constexpr double near_sigmas = 8, near_sigmas_among_outliers = 5;
constexpr int rounds = 3;

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from, std::size_t size) {
  if (to.size() == size) to.insert(to.end(), from.begin(), from.end());
}

std::vector<std::uint8_t> near_surface(const Candidate& candidate, const std::vector<Vec3>& points, double reach,
                                       Context& context) {
  const ModelDistance distance(bare_model(candidate));
  const Pose part_from_scan = candidate.scan_from_part.inverse();
  std::vector<std::uint8_t> near(points.size());
  parallel_for(points.size(), context.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) near[i] = std::abs(distance(part_from_scan * points[i]).distance) < reach;
  });
  return near;
}

FitInput with_back(const FitInput& input, const std::vector<std::uint8_t>& back) {
  PointCloud more = input.set_aside;
  keep_points(more, back);
  FitInput result = input;
  const std::size_t n = input.cloud.size();
  PointCloud& cloud = result.cloud;
  append(cloud.normals, more.normals, n), append(cloud.rays, more.rays, n), append(cloud.sigma, more.sigma, n),
      append(cloud.view, more.view, n);
  append(cloud.points, more.points, n);
  result.surface_share.clear(), result.surroundings.reset();
  return result;
}

/// The scan with the points at these places no longer rejected.
Scan with_back(const Scan& scan, std::vector<Vec3> places) {
  Scan result = scan;
  const std::vector<std::uint8_t> back = points_at(scan.cloud, std::move(places));
  for (std::size_t i = 0; i < result.cloud.rejected.size(); ++i)
    if (back[i]) result.cloud.rejected[i] = 0;
  return result;
}

}  // namespace

bool axes_from_slopes(const Shape& shape) {
  return std::holds_alternative<Ellipsoid>(shape) || std::holds_alternative<Superellipsoid>(shape);
}

RefineReport refine_with_outliers_near(Candidate& candidate, const FitInput& input, const RefineOptions& options,
                                       Context& context) {
  if (input.set_aside.empty() || (among_outliers(input) && !axes_from_slopes(candidate.shape)))
    return refine(candidate, input, options, context);
  RefineOptions quick = options;
  quick.points = std::min<std::size_t>(options.points, 6000), quick.iterations = 25, quick.uncertainty = false;
  const double reach = (among_outliers(input) ? near_sigmas_among_outliers : near_sigmas) * input.sampling.sigma;
  std::vector<std::uint8_t> back;
  for (int round = 0; round < rounds && !context.cancelled; ++round) {
    if (round > 0) refine(candidate, with_back(input, back), quick, context);
    std::vector<std::uint8_t> now = near_surface(candidate, input.set_aside.points, reach, context);
    if (now == back) break;
    back = std::move(now);
  }
  FitInput all = with_back(input, back);
  if (!input.scan) return refine(candidate, all, options, context);
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < back.size(); ++i)
    if (back[i]) places.push_back(input.set_aside.points[i]);
  const Scan scan = with_back(*input.scan, std::move(places));
  all.scan = &scan;
  return refine(candidate, all, options, context);
}

}  // namespace partscribe::fit
