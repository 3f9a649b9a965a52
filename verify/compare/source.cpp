#include "verify/compare/source.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/number.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "geometry/least_squares.h"
#include "geometry/normals/local_noise.h"
#include "geometry/points/thin.h"
#include "geometry/segment/faces.h"
#include "verify/compare/samples.h"

namespace partscribe::verify {
namespace {

constexpr int noise_neighbours = 24;
constexpr std::size_t noise_places = 6000;
constexpr double smooth = 3;                  // times the noise: scatter about a quadric above which there is an edge
constexpr std::size_t enough_points = 20000;  // a mesh with fewer vertices is sampled as well

/// Heights of the neighbourhood over its own quadratic surface; false if it has none.
bool heights_over_quadric(const std::vector<Vec3>& points, const std::vector<Neighbour>& group,
                          std::vector<double>& heights) {
  Vec3 mean = Vec3::Zero();
  for (const auto& n : group) mean += points[n.index];
  mean /= static_cast<double>(group.size());
  Mat3 covariance = Mat3::Zero();
  for (const auto& n : group) covariance += (points[n.index] - mean) * (points[n.index] - mean).transpose();
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.computeDirect(covariance);
  const Mat3 frame = solver.eigenvectors();
  const double scale = std::sqrt(std::max(solver.eigenvalues()[2] / static_cast<double>(group.size()), 1e-300));
  using Row = Eigen::Matrix<double, 6, 1>;
  NormalSums<6> sums;
  std::vector<Row> rows;
  heights.clear();
  for (const auto& n : group) {
    const Vec3 q = frame.transpose() * (points[n.index] - mean) / scale;
    Row row;
    row << 1, q.y(), q.z(), q.y() * q.y(), q.y() * q.z(), q.z() * q.z();
    sums.add(row, q.x());
    rows.push_back(row), heights.push_back(q.x());
  }
  const Row fit = sums.solution(1e-12 * static_cast<double>(group.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) heights[i] = (heights[i] - rows[i].dot(fit)) * scale;
  return group.size() > 6;
}

/// Outliers hardly count.
double scatter_of(std::vector<double> heights) {
  const auto size = static_cast<double>(heights.size());
  for (auto& h : heights) h = std::abs(h);
  return 1.4826 * median_in_place(heights) * std::sqrt(size / (size - 6));
}

/// Scatter of the neighbourhood about its own quadratic surface: curvature does not count as noise.
double scatter(const std::vector<Vec3>& points, const std::vector<Neighbour>& group) {
  std::vector<double> heights;
  return heights_over_quadric(points, group, heights) ? scatter_of(std::move(heights)) : 0;
}

/// The other side of a thin wall was seen from the other side.
bool seen_from_one_side(const ScanSource& source, std::size_t a, std::size_t b) {
  return source.rays.empty() || source.rays[a].dot(source.rays[b]) >= -0.1;
}

/// As local_noise() finds it, from neighbourhoods that are wide enough to show surface.
LocalNoise noise_in_wider_neighbourhoods(const ScanSource& source, int threads) {
  const auto nearest = [&](std::uint32_t i, std::size_t count, std::vector<Neighbour>& near) {
    for (std::size_t asked = count;; asked *= 2) {
      source.tree->nearest(source.points[i], asked, near);
      if (source.rays.empty()) return;
      const auto same_side = [&](const Neighbour& n) { return seen_from_one_side(source, n.index, i); };
      const auto other_side = std::stable_partition(near.begin(), near.end(), same_side);
      // Far more than were asked for are another place: then the nearest of the other side fill up the number.
      if (static_cast<std::size_t>(other_side - near.begin()) >= count || asked >= 4 * count ||
          asked >= source.points.size())
        return;
    }
  };
  return local_noise(source.points, nearest, threads);
}

/// One view's surface is sparser than that of all views together, and three times sparser still where it is seen at
/// 80 degrees. Without views nobody knows how many overlap: four times the usual spacing.
/// `mesh`: of the scan, may be empty. What scatters beside the corners of a drawn part are its facets, no noise.
void measure(ScanSource& source, const std::vector<std::int32_t>& view, const TriangleMesh& mesh, int threads) {
  const std::size_t places = std::min(noise_places, source.points.size());
  std::vector<double> spacings(places), noises(places, -1), closer(places, -1), overlaps(places);
  parallel_for(
      places, threads,
      [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbour> near;
        for (std::size_t i = begin; i < end; ++i) {
          const std::size_t at = i * source.points.size() / places;
          source.tree->nearest(source.points[at], noise_neighbours, near);
          spacings[i] =
              near.size() > 1
                  ? spacing_from_eighth(std::sqrt(near[std::min<std::size_t>(8, near.size() - 1)].sq_distance))
                  : 0;
          if (!view.empty()) {
            std::vector<std::int32_t> views;
            for (const auto& n : near) views.push_back(view[n.index]);
            std::sort(views.begin(), views.end());
            overlaps[i] = static_cast<double>(std::unique(views.begin(), views.end()) - views.begin());
          }
          std::erase_if(near, [&](const Neighbour& n) { return !seen_from_one_side(source, n.index, at); });
          if (near.size() <= 12) continue;
          noises[i] = scatter(source.points, near);
          near.resize(13);
          closer[i] = scatter(source.points, near);
        }
      },
      64);
  source.spacing = median(spacings);
  // Where features are hardly wider than the larger neighbourhoods, their shape counts as scatter: the smaller ones see
  // less of it.
  std::erase(noises, -1.0), std::erase(closer, -1.0);
  source.noise = std::min(median(noises), median(closer));
  // What remains of an exact surface is rounding, not noise; relative to the part, for it may lie far from the origin.
  Box3 box;
  for (const auto& p : source.points) box.add(p);
  const double rounding = 1e-6 * box.diagonal();
  // Neighbourhoods that are narrower than noise is thick show a ball of noise, no surface.
  const LocalNoise wider = noise_in_wider_neighbourhoods(source, threads);
  const bool scatters = source.noise >= rounding || wider.flat_sigma > rounding;
  const bool drawn = scatters && !mesh.empty() && is_drawn(mesh);
  if (drawn || source.noise < rounding) source.noise = 0;
  const double reach = wider.flat_pitch * std::sqrt(noise_neighbours / pi);
  source.dense = !drawn && wider.flat_sigma > rounding && reach < thickness_of_noise(wider.flat_sigma);
  if (source.dense) source.noise = wider.flat_sigma, source.spacing = wider.flat_pitch;
  source.sparsest = view.empty() ? 4 * source.spacing : 3 * source.spacing * std::sqrt(median(overlaps));
}

/// How far the means of the views in one neighbourhood lie from the mean of the others along the normal: squares, less
/// what noise alone does to means. Nothing at edges, where two views show two faces.
std::vector<std::pair<std::int32_t, double>> sq_offsets_at(const ScanSource& source,
                                                           const std::vector<std::int32_t>& view, std::size_t at,
                                                           std::vector<Neighbour>& near) {
  source.tree->nearest(source.points[at], 2 * noise_neighbours, near);
  std::erase_if(near, [&](const Neighbour& n) { return !seen_from_one_side(source, n.index, at); });
  std::vector<double> heights;
  if (near.size() < noise_neighbours || !heights_over_quadric(source.points, near, heights)) return {};
  if (scatter_of(heights) > smooth * source.noise) return {};
  struct Sum {
    double height = 0, count = 0;
    double mean() const { return height / count; }
  };
  std::map<std::int32_t, Sum> sums;
  for (std::size_t k = 0; k < near.size(); ++k)
    if (std::abs(heights[k]) < std::max(20 * source.noise, source.spacing)) {
      Sum& sum = sums[view[near[k].index]];
      sum.height += heights[k], sum.count += 1;
    }
  std::erase_if(sums, [](const auto& entry) { return entry.second.count < 6; });
  double all = 0, all_variance = 0;
  for (const auto& [v, sum] : sums) all += sum.mean(), all_variance += 1 / sum.count;
  const auto others = static_cast<double>(sums.size()) - 1;
  std::vector<std::pair<std::int32_t, double>> offsets;
  for (const auto& [v, sum] : sums) {
    if (others < 1) break;
    const double off = sum.mean() - (all - sum.mean()) / others;
    const double variance = 1 / sum.count + (all_variance - 1 / sum.count) / (others * others);
    offsets.emplace_back(v, off * off - source.noise * source.noise * variance);
  }
  return offsets;
}

template <class T>
std::vector<T> every_nth(const std::vector<T>& all, std::size_t stride) {
  std::vector<T> some;
  for (std::size_t i = 0; i < all.size(); i += stride) some.push_back(all[i]);
  return some;
}

/// Of a dense cloud thinned so much, the nearest points reach as far as the noise is thick.
std::size_t stride_to_surface(const ScanSource& source) {
  const double reach = thickness_of_noise(source.noise) / source.spacing;
  return std::max<std::size_t>(1, static_cast<std::size_t>(pi * reach * reach / noise_neighbours));
}

/// A cloud of ordinary density: what its neighbourhoods show is surface.
ScanSource every_nth(const ScanSource& source, std::size_t stride) {
  ScanSource some;
  some.points = every_nth(source.points, stride), some.rays = every_nth(source.rays, stride);
  some.tree = std::make_unique<KdTree>(some.points);
  some.noise = source.noise, some.spacing = source.spacing * std::sqrt(static_cast<double>(stride));
  return some;
}

/// Views that were laid onto each other wrongly run beside each other: of the view that lies farthest off, the root
/// mean square of its offsets from the others, without the largest twentieth.
double disagreement_of(const ScanSource& source, const std::vector<std::int32_t>& view, int threads) {
  if (view.empty()) return 0;
  if (source.dense) {
    const std::size_t stride = stride_to_surface(source);
    return disagreement_of(every_nth(source, stride), every_nth(view, stride), threads);
  }
  const std::size_t places = std::min(noise_places, source.points.size());
  std::vector<std::vector<std::pair<std::int32_t, double>>> offsets(places);
  parallel_for(
      places, threads,
      [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbour> near;
        for (std::size_t i = begin; i < end; ++i)
          offsets[i] = sq_offsets_at(source, view, i * source.points.size() / places, near);
      },
      64);
  std::map<std::int32_t, std::vector<double>> of_view;
  for (const auto& place : offsets)
    for (const auto& [v, square] : place) of_view[v].push_back(square);
  double worst = 0;
  for (auto& [v, squares] : of_view) {
    if (squares.size() < 50) continue;
    std::sort(squares.begin(), squares.end());
    const std::size_t used = squares.size() * 19 / 20;
    double sum = 0;
    for (std::size_t i = 0; i < used; ++i) sum += squares[i];
    worst = std::max(worst, sum / static_cast<double>(used));
  }
  return std::sqrt(worst);
}

}  // namespace

double spacing_from_eighth(double distance) { return distance * 0.62665706865775; }  // sqrt(pi / 8)

ScanSource prepare_source(const Scan& scan, Context& context) {
  ScanSource source;
  const PointCloud& cloud = scan.cloud;
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    if (!cloud.points[i].allFinite()) continue;
    if (!cloud.rejected.empty() && cloud.rejected[i])
      source.set_aside.push_back(cloud.points[i]);
    else
      kept.push_back(i);
  }
  source.kept = kept.size();
  source.sights = sight_maps(cloud, scan.views, kept);

  std::vector<Vec3> points, normals, rays;
  points.reserve(kept.size());
  bool any_ray = !cloud.rays.empty();
  for (const auto& view : scan.views) any_ray = any_ray || view.has_sensor;
  const bool any_normal = !cloud.normals.empty();
  for (const auto i : kept) {
    points.push_back(cloud.points[i]);
    if (any_normal) normals.push_back(cloud.normals[i]);
    if (any_ray) {
      Vec3 ray = cloud.rays.empty() ? Vec3(0, 0, 0) : cloud.rays[i];
      const auto v = static_cast<std::size_t>(cloud.view.empty() ? 0 : std::max(cloud.view[i], 0));
      if (ray.squaredNorm() < 0.5 && v < scan.views.size() && scan.views[v].has_sensor)
        ray = (cloud.points[i] - scan.views[v].world_from_view.translation).normalized();
      rays.push_back(ray);
    }
  }
  if (!scan.mesh.empty()) {
    source.surface = std::make_unique<MeshDistance>(scan.mesh);
    source.closed_surface = topology(welded(scan.mesh, 0)).closed();
    if (points.size() < enough_points)
      for (const auto& s : even_samples(scan.mesh, enough_points - points.size())) {
        points.push_back(s.point);
        if (any_normal) normals.push_back(triangle_normal(scan.mesh, s.triangle));
        if (any_ray) rays.push_back(Vec3::Zero());
      }
  }
  const auto order = coordinate_order(points);
  for (const auto i : order) {
    source.points.push_back(points[i]);
    source.kept_place.push_back(i < kept.size() ? i : ScanSource::nowhere);
    if (any_normal) source.normals.push_back(normals[i]);
    if (any_ray) source.rays.push_back(rays[i]);
  }
  source.tree = std::make_unique<KdTree>(source.points);
  for (const auto k : source.kept_place) {
    std::int32_t sight = -1;
    for (std::size_t s = 0; s < source.sights.size() && k != ScanSource::nowhere && sight < 0; ++s)
      if (source.sights[s].view == (cloud.view.empty() ? 0 : cloud.view[kept[k]])) sight = static_cast<std::int32_t>(s);
    source.sight.push_back(sight);
  }
  std::vector<std::int32_t> view;
  if (!cloud.view.empty() && scan.mesh.empty())
    for (const auto k : source.kept_place) view.push_back(cloud.view[kept[k]]);
  if (source.points.size() > 1) measure(source, view, scan.mesh, context.threads);
  if (source.points.size() > 1) source.disagreement = disagreement_of(source, view, context.threads);
  return source;
}

int most_neighbours(const ScanSource& source) {
  return static_cast<int>(std::clamp<std::size_t>(source.points.size() / 50, 9, 100));
}

int neighbours_for(const ScanSource& source, double tolerance) {
  const double ratio = 4 * 3.3 * source.noise / tolerance;
  const double wanted = std::ceil(std::min(ratio * ratio, 1e6));
  return std::clamp(static_cast<int>(wanted), 9, most_neighbours(source));
}

double smallest_honest_tolerance(const ScanSource& source) {
  const double by_noise = 4 * 3.3 * source.noise / std::sqrt(static_cast<double>(most_neighbours(source)));
  return std::max(by_noise, view_reach * source.disagreement);
}

std::optional<LineOfSight> line_of_sight(const ScanSource& source, std::size_t point, double reach) {
  const auto number = source.sights.empty() ? -1 : source.sight[point];
  if (number < 0) return {};
  const SightMap& map = source.sights[static_cast<std::size_t>(number)];
  const Vec3 &p = source.points[point], &ray = source.rays[point];
  if (map.parallel) return LineOfSight{p - reach * ray, ray, reach, map.pitch};
  const Vec3 from = map.view_from_world.inverse().translation;
  const double length = (p - from).norm();
  return LineOfSight{from, (p - from) / length, length, map.pitch * (map.view_from_world * p).z()};
}

std::optional<MeshHit> hidden_by(const MeshDistance& surface, const LineOfSight& sight, double margin,
                                 const Vec3& aside) {
  if (sight.length <= margin) return {};
  return surface.first_hit(sight.from + aside, sight.ray, sight.length - margin);
}

}  // namespace partscribe::verify
