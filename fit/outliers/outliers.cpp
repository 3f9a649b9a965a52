#include "fit/outliers/outliers.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "core/disjoint_sets.h"
#include "core/parallel.h"
#include "core/sample_consensus.h"
#include "core/statistics.h"
#include "geometry/points/kd_tree.h"

namespace partscribe::fit {
namespace {

constexpr std::size_t least_neighbours = 20, most_neighbours = 90;
constexpr int drawn_planes = 25;
constexpr double good_share = 0.72;  // of the neighbours on a point's plane; a ball of outliers reaches 0.6 by chance
constexpr double clear_share = 0.9;  // nine in ten points of a face have more on theirs
constexpr double edge_on = 0.1;      // cosine between normal and ray; no surface returns light at 84 degrees
constexpr double everywhere = 0.1;   // share of the points; above it sparse points are taken for outliers
constexpr double thin_out = 0.1;     // of the middle density of a surface; sparser is sparse

/// The plane near a point that holds most of its neighbours.
struct LocalPlane {
  Vec3 normal = Vec3::UnitZ();
  Vec3 middle = Vec3::Zero();
  double radius = 0;      // of the neighbourhood
  double share = 0;       // of the neighbours within the band, but those of a face that looks the other way
  std::size_t asked = 0;  // neighbours that count
  double residual = 0;    // median distance of those from it
};

/// Half the thickness of what counts as on a plane at a distance: noise, and a surface that bends.
double band(double sigma, double distance) { return 2.5 * sigma + 0.06 * distance; }

/// Whether a sample was seen from behind a plane that another was seen to face: the far side of a thin wall.
bool sees_other_side(const Vec3& normal, const Vec3& own_ray, const Vec3& ray) {
  const double own = normal.dot(own_ray), other = normal.dot(ray);
  return own * other < 0 && std::min(std::abs(own), std::abs(other)) > edge_on;
}

/// Neighbours nearer than so many sigmas, or than a share of the neighbourhood's radius, do not determine the direction
/// of a plane.
constexpr double apart_sigmas = 2, apart_share = 0.4;

/// Where points are so dense that all nearest neighbours are nearer than that, they determine no plane, and the densest
/// part of a surface would be taken for a cluster of outliers. Then as many neighbours are taken from those at a
/// sufficient distance.
void reach_beyond_noise(const KdTree& tree, const Vec3& p, double sigma, std::vector<Neighbour>& near) {
  if (near.size() < most_neighbours || std::sqrt(near.back().sq_distance) > apart_sigmas * sigma) return;
  std::vector<Neighbour> all;
  tree.within(p, apart_sigmas / apart_share * sigma, all);
  if (all.size() <= near.size()) return;
  const double step = double(all.size() - 1) / double(near.size() - 1);
  for (std::size_t k = 0; k < near.size(); ++k) near[k] = all[static_cast<std::size_t>(std::lround(double(k) * step))];
}

/// `rays`: of each point, or none.
LocalPlane plane_near(const std::vector<Vec3>& points, const std::vector<Vec3>& rays, std::span<const Neighbour> near,
                      std::size_t self, double sigma) {
  LocalPlane plane;
  const Vec3& p = points[self];
  const auto counts = [&](const Vec3& normal, std::uint32_t i) {
    return rays.empty() || !sees_other_side(normal, rays[self], rays[i]);
  };
  plane.middle = p;
  plane.radius = std::sqrt(near.back().sq_distance);
  const double apart = std::max(apart_share * plane.radius, apart_sigmas * sigma);
  std::vector<std::uint32_t> far;
  for (const auto& n : near)
    if (n.sq_distance > apart * apart) far.push_back(n.index);
  if (far.size() < 4) return plane;
  Random random(0x9e3779b9u + near.size() * 977 + far.front() * 31ull + far.back());
  const auto through_two = [&](auto offer) {
    const Vec3 a = points[drawn_from(far, random)] - p, b = points[drawn_from(far, random)] - p, n = a.cross(b);
    const double length = n.norm();
    if (length > 0.4 * a.norm() * b.norm()) offer(n / length);
  };
  const auto points_on = [&](const Vec3& n, double) {
    return double(std::ranges::count_if(near, [&](const Neighbour& m) {
      return std::abs(n.dot(points[m.index] - p)) < band(sigma, std::sqrt(m.sq_distance)) && counts(n, m.index);
    }));
  };
  const auto best = consensus<Vec3>(drawn_planes, 0, through_two, points_on);
  if (!best) return plane;
  plane.normal = best->hypothesis;
  double across = 0;  // spread in the plane's narrower direction
  for (int round = 0; round < 3; ++round) {
    Vec3 mean = Vec3::Zero();
    std::vector<std::uint32_t> on;
    for (const auto& m : near)
      if (std::abs(plane.normal.dot(points[m.index] - plane.middle)) < band(sigma, std::sqrt(m.sq_distance)) &&
          counts(plane.normal, m.index))
        on.push_back(m.index), mean += points[m.index];
    if (on.size() < 5) break;
    mean /= double(on.size());
    Mat3 scatter = Mat3::Zero();
    for (const auto i : on) scatter += (points[i] - mean) * (points[i] - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(scatter);
    plane.normal = eigen.eigenvectors().col(0);
    across = std::sqrt(std::max(eigen.eigenvalues()[1], 0.0) / double(on.size()));
    plane.middle = mean;
  }
  std::vector<double> off;
  for (const auto& m : near) {
    if (m.index == self || !counts(plane.normal, m.index)) continue;
    ++plane.asked;
    const double d = std::abs(plane.normal.dot(points[m.index] - plane.middle));
    if (d < band(sigma, std::sqrt(m.sq_distance))) off.push_back(d);
  }
  plane.share = plane.asked == 0 ? 0 : double(off.size()) / double(plane.asked);
  // A small dense dot is thin in every direction.
  if (across < 0.15 * plane.radius) plane.share = 0;
  plane.residual = median(std::move(off));
  return plane;
}

/// Of the points left those so sparse that they are a curtain rather than a surface, if there are many outliers.
std::vector<std::uint32_t> sparse_points(const std::vector<Vec3>& points, const SurfacePoints& result,
                                         Context& context) {
  std::vector<std::uint32_t> source, found;
  std::vector<Vec3> kept;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!result.outlier[i]) source.push_back(static_cast<std::uint32_t>(i)), kept.push_back(points[i]);
  if (kept.size() < 3 * least_neighbours) return found;
  const KdTree tree(kept);
  std::vector<double> sq_radius(kept.size());
  parallel_for(kept.size(), context.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    for (std::size_t i = begin; i < end; ++i) {
      tree.nearest(kept[i], least_neighbours, near);
      sq_radius[i] = near.back().sq_distance;
    }
  });
  const double widest = median(sq_radius) / thin_out;
  for (std::size_t i = 0; i < kept.size(); ++i)
    if (sq_radius[i] > widest) found.push_back(source[i]);
  return found;
}

/// True if most of some points lie on planes that hold as many of their neighbours as a face's do.
bool clear_planes(const std::vector<std::uint32_t>& some, const SurfacePoints& result) {
  std::vector<double> shares;
  for (const std::uint32_t i : some) shares.push_back(double(result.share[i]));
  return !shares.empty() && median(std::move(shares)) > clear_share;
}

/// Marks clusters of points that stand apart from everything else and are dots or threads: too narrow for noise to
/// leave a face.
void set_dots_aside(const std::vector<Vec3>& points, SurfacePoints& result) {
  constexpr double apart = 4, widest = 6,
                   narrowest = 2;  // sigmas: to the next point; standard deviations along and across
  constexpr double large = 0.2;    // share of the points: the part itself
  std::vector<std::uint32_t> source;
  std::vector<Vec3> kept;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!result.outlier[i]) source.push_back(static_cast<std::uint32_t>(i)), kept.push_back(points[i]);
  if (kept.empty()) return;
  const KdTree tree(kept);
  DisjointSets heaps(kept.size());
  std::vector<Neighbour> near;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    tree.within(kept[i], apart * result.sigma, near);
    for (const auto& m : near) heaps.unite(static_cast<std::uint32_t>(i), m.index);
  }
  std::map<std::uint32_t, std::vector<std::uint32_t>> members;
  for (std::size_t i = 0; i < kept.size(); ++i)
    members[heaps.root(static_cast<std::uint32_t>(i))].push_back(static_cast<std::uint32_t>(i));
  for (const auto& [root, heap] : members) {
    if (heap.size() < least_neighbours || double(heap.size()) > large * double(kept.size())) continue;
    Vec3 mean = Vec3::Zero();
    for (const auto i : heap) mean += kept[i] / double(heap.size());
    Mat3 scatter = Mat3::Zero();
    for (const auto i : heap) scatter += (kept[i] - mean) * (kept[i] - mean).transpose() / double(heap.size());
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(scatter);
    const bool dot = std::sqrt(eigen.eigenvalues()[2]) < widest * result.sigma,
               thread = std::sqrt(eigen.eigenvalues()[1]) < narrowest * result.sigma;
    if (!dot && !thread) continue;
    for (const auto i : heap) result.outlier[source[i]] = 1, ++result.outliers;
  }
}

}  // namespace

SurfacePoints surface_points_of(const std::vector<Vec3>& points, const std::vector<Vec3>& rays, double sigma,
                                Context& context) {
  const std::size_t n = points.size();
  SurfacePoints result;
  result.outlier.assign(n, 0), result.normals.assign(n, Vec3::Zero()), result.sigma = sigma, result.share.assign(n, 0);
  constexpr int last_pass = 3;
  // times the previous estimate of the noise: with a band that much narrower, further points may be outliers
  constexpr double fell = 0.8;
  int narrower = 8;  // times; a guess six times the noise comes down to it
  for (int pass = 0; pass <= last_pass && !context.cancelled; ++pass) {
    const double thought = result.sigma;
    std::vector<std::uint32_t> source;
    std::vector<Vec3> kept, kept_rays;
    for (std::size_t i = 0; i < n; ++i)
      if (!result.outlier[i]) {
        source.push_back(static_cast<std::uint32_t>(i)), kept.push_back(points[i]);
        if (rays.size() == n) kept_rays.push_back(rays[i]);
      }
    if (kept.size() < 3 * least_neighbours) break;
    const KdTree tree(kept);
    const std::size_t count = kept.size();
    std::vector<LocalPlane> planes(count);
    std::vector<std::vector<Neighbour>> neighbours(count);
    const double reach = 10 * result.sigma;
    parallel_for(count, context.threads, [&](std::size_t begin, std::size_t end) {
      std::vector<Neighbour> near;
      for (std::size_t i = begin; i < end; ++i) {
        tree.nearest(kept[i], most_neighbours, near);
        reach_beyond_noise(tree, kept[i], result.sigma, near);
        std::size_t used = std::min(least_neighbours, near.size());
        while (used < near.size() && near[used].sq_distance < reach * reach) ++used;
        planes[i] = plane_near(kept, kept_rays, {near.data(), used}, i, result.sigma);
        while (planes[i].asked < least_neighbours - 1 && used < near.size()) {  // too few of its own side
          used = std::min(used + least_neighbours / 2, near.size());
          planes[i] = plane_near(kept, kept_rays, {near.data(), used}, i, result.sigma);
        }
        near.resize(used);
        if (!kept_rays.empty() && std::abs(planes[i].normal.dot(kept_rays[i])) < edge_on) planes[i].share = 0;
        neighbours[i] = near;
      }
    });
    std::vector<std::uint8_t> outlier(count, 0);
    parallel_for(count, context.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        std::size_t support = 0;
        for (const auto& m : neighbours[i]) {
          const LocalPlane& plane = planes[m.index];
          if (m.index == i || plane.share < good_share || m.sq_distance > plane.radius * plane.radius) continue;
          const double d = std::abs(plane.normal.dot(kept[i] - plane.middle));
          support += d < band(1.4 * result.sigma, std::sqrt(m.sq_distance));
        }
        outlier[i] = support < 3;
      }
    });
    std::vector<double> residuals;
    std::size_t found = 0;
    for (std::size_t i = 0; i < count; ++i) {
      result.normals[source[i]] = planes[i].normal, result.share[source[i]] = static_cast<float>(planes[i].share);
      if (outlier[i])
        result.outlier[source[i]] = 1, ++found;
      else if (planes[i].share > 0.85)
        residuals.push_back(planes[i].residual);
    }
    result.outliers += found;
    // Sigma of a Gaussian truncated at the band; curved pieces have values above the median of these medians.
    if (residuals.size() > 50) result.sigma = std::min(result.sigma, 1.4826 * median(residuals) * 1.03);
    const bool hardly_any = found * 500 < count;
    if (hardly_any && result.sigma < fell * thought && narrower-- > 0) {
      --pass;
      continue;
    }
    if (hardly_any || pass == last_pass) {
      // Pieces that are connected: each point lies on the plane of the other.
      DisjointSets pieces(count);
      for (std::size_t i = 0; i < count; ++i)
        for (const auto& m : neighbours[i]) {
          const LocalPlane& plane = planes[m.index];
          if (outlier[i] || outlier[m.index] || plane.share < good_share || m.sq_distance > plane.radius * plane.radius)
            continue;
          if (std::abs(plane.normal.dot(kept[i] - plane.middle)) < band(1.4 * result.sigma, std::sqrt(m.sq_distance)))
            pieces.unite(static_cast<std::uint32_t>(i), m.index);
        }
      for (std::size_t i = 0; i < count; ++i)
        if (!outlier[i] && 100 * std::size_t{pieces.size(static_cast<std::uint32_t>(i))} < 3 * count)
          result.outlier[source[i]] = 1, ++result.outliers;
      break;
    }
  }
  // In a box hardly thicker than the noise, outliers lie on one another's planes. They are sparse, and their planes
  // contain fewer of the neighbours than those of a face.
  const std::vector<std::uint32_t> sparse = sparse_points(points, result, context);
  const std::size_t strewn = clear_planes(sparse, result) ? 0 : sparse.size();
  if (double(result.outliers + strewn) > everywhere * double(n)) {
    for (const std::uint32_t i : sparse) result.outlier[i] = 1;
    result.outliers += sparse.size();
    set_dots_aside(points, result);
  }
  return result;
}

}  // namespace partscribe::fit
