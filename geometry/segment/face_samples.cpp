#include "geometry/segment/face_samples.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "core/statistics.h"
#include "geometry/points/kd_tree.h"
#include "geometry/points/thin.h"

namespace partscribe::geometry {
namespace {

constexpr std::size_t most_links = 12;
constexpr double farthest_link = 4;     // pitches
constexpr double spacing_by_noise = 4;  // sigmas

}  // namespace

FaceSamples face_samples(const PointCloud& cloud, const std::vector<std::uint8_t>& left_out, double least_sigma,
                         double spacing, int threads) {
  FaceSamples samples;
  std::vector<double> sigmas;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (!left_out[i]) sigmas.push_back(cloud.sigma[i]);
  // Closer together than their noise is thick, samples are neighbours across the surface as often as along it.
  spacing = std::max(spacing, spacing_by_noise * median_in_place(sigmas));
  samples.source = thinned(cloud.points, left_out, spacing);
  for (const auto i : samples.source) {
    samples.points.push_back(cloud.points[i]);
    samples.normals.push_back(cloud.normals[i]);
    samples.sigma.push_back(std::max(least_sigma, static_cast<double>(cloud.sigma[i])));
  }
  const std::size_t count = samples.size();
  std::vector<std::uint32_t> nearest(count * most_links, ~0u);
  std::vector<double> reach(count, 0), closest(count, 0);
  const KdTree tree(samples.points);
  tree.nearest_of_each(most_links + 1, threads, [&](std::uint32_t i, std::span<const Neighbour> near) {
    std::size_t k = 0;
    for (const auto& n : near)
      if (n.index != i && k < most_links) {
        nearest[i * most_links + k++] = n.index;
        reach[i] = n.sq_distance;
        if (k == 4) closest[i] = std::sqrt(n.sq_distance);
      }
  });
  // The mean distance of an even grid's four neighbours is its pitch.
  samples.pitch = median(closest);
  std::vector<double> areas;
  for (const double r : reach) areas.push_back(pi * r / (most_links + 0.5));
  samples.area = median(std::move(areas));
  samples.first.push_back(0);
  for (std::uint32_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < most_links; ++k) {
      const auto j = nearest[i * most_links + k];
      if (j != ~0u && (samples.points[i] - samples.points[j]).norm() <= farthest_link * samples.pitch)
        samples.links.push_back(j);
    }
    samples.first.push_back(static_cast<std::uint32_t>(samples.links.size()));
  }
  return samples;
}

}  // namespace partscribe::geometry
