#include "scan/merge/merge.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <numeric>

#include "core/ensure.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "geometry/points/kd_tree.h"

namespace partscribe::scan {
namespace {

constexpr double same_side = 0.5;  // cosine between normals of one surface

/// Median distance between neighbours of one view, over all views.
double view_spacing(const PointCloud& cloud, const std::vector<std::uint32_t>& usable) {
  constexpr std::size_t asked_per_view = 300;
  std::map<std::int32_t, std::vector<Vec3>> views;
  for (const auto i : usable) views[cloud.view[i]].push_back(cloud.points[i]);
  std::vector<double> distances;
  std::vector<Neighbour> near;
  for (const auto& [view, points] : views) {
    const KdTree tree(points);
    const std::size_t step = std::max<std::size_t>(1, points.size() / asked_per_view);
    for (std::size_t i = 0; i < points.size(); i += step) {
      tree.nearest(points[i], 2, near);
      if (near.size() == 2) distances.push_back(std::sqrt(near[1].sq_distance));
    }
  }
  return distances.empty() ? 0 : median(std::move(distances));
}

/// Accepted samples in chains, one for all cells with the same hash: distances tell whose cell it is.
class Disks {
 public:
  Disks(const PointCloud& cloud, double spacing, std::size_t count)
      : cloud_(cloud), spacing_(spacing), first_(std::bit_ceil(count), none), next_(cloud.size(), none) {}

  void add(std::uint32_t i) {
    std::uint32_t& first = first_[slot(cell(cloud_.points[i]))];
    next_[i] = first, first = i;
  }
  /// The nearest accepted sample within `reach` (at most the spacing) on the same side; -1 if there is none.
  std::int64_t nearest(std::uint32_t i, double reach) const {
    const Vec3& p = cloud_.points[i];
    const auto [x, y, z] = cell(p);
    double best = reach * reach;
    std::int64_t found = -1;
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz)
          for (std::uint32_t k = first_[slot({x + dx, y + dy, z + dz})]; k != none; k = next_[k]) {
            const double d = (cloud_.points[k] - p).squaredNorm();
            if (d >= best || (known(i) && known(k) && cloud_.normals[i].dot(cloud_.normals[k]) < same_side)) continue;
            best = d, found = k;
          }
    return found;
  }
  bool known(std::uint32_t i) const { return !cloud_.normals[i].isZero(); }

 private:
  static constexpr std::uint32_t none = ~std::uint32_t(0);
  using Cell = std::array<std::int64_t, 3>;
  Cell cell(const Vec3& p) const {
    Cell c;
    for (int k = 0; k < 3; ++k) c[static_cast<std::size_t>(k)] = static_cast<std::int64_t>(std::floor(p[k] / spacing_));
    return c;
  }
  std::size_t slot(const Cell& c) const {
    std::uint64_t h = 0x9e3779b97f4a7c15ull;
    for (const auto v : c) h = (h ^ static_cast<std::uint64_t>(v)) * 0xbf58476d1ce4e5b9ull, h ^= h >> 29;
    return h & (first_.size() - 1);
  }
  const PointCloud& cloud_;
  double spacing_;
  std::vector<std::uint32_t> first_, next_;
};

/// Whether two samples around one, of whatever view, lie on the same surface: the five nearest are asked, and more
/// within `reach`. True where nobody can tell.
bool confirmed(const PointCloud& cloud, const KdTree& tree, const std::vector<std::uint32_t>& usable, std::uint32_t i,
               double reach, const MergeOptions& options, std::vector<Neighbour>& near) {
  constexpr std::size_t most = 16;  // of thousands of overlapping views the nearest are enough
  constexpr int least = 5;          // near or far: a view may be sparser than the others
  constexpr int enough = 2;         // three leave out up to 0.4 % more, hardly any of them far off
  const Vec3 &p = cloud.points[i], &n = cloud.normals[i];
  const double cosine = std::cos(options.max_normal_angle);
  int agreeing = 0, asked = 0;
  tree.nearest(p, most, near);
  for (const Neighbour& neighbour : near) {
    const std::uint32_t k = usable[neighbour.index];
    const Vec3& m = cloud.normals[k];
    if (k == i || m.isZero() || m.dot(n) < 0) continue;  // who saw the other side of a wall cannot tell
    if (++asked > least && neighbour.sq_distance > reach * reach) break;
    if (!n.isZero() && !(m.dot(n) > cosine)) continue;
    // Off the other's plane; on a round face, where that bends away, the mean of both normals knows better.
    const Vec3 d = cloud.points[k] - p;
    // What is hardly known itself confirms no more than the sample's own noise.
    const double own = std::max<double>(cloud.sigma[i], 1e-9),
                 limit = options.max_sigmas * std::hypot(own, std::clamp<double>(cloud.sigma[k], 1e-9, own));
    const double off = m.dot(d), off_both = (m + n).normalized().dot(d);
    agreeing += std::abs(off) < limit || std::abs(off_both) < limit || off * off_both < 0;
    if (agreeing == enough) return true;
  }
  return asked < enough;
}

/// Where the views around a sample see the surface, along the sample's normal.
struct Mean {
  double shift = 0, sigma = 0;
  Vec3 normal = Vec3::Zero();
};

Mean mean_around(const PointCloud& cloud, std::uint32_t i, const std::vector<std::uint32_t>& samples,
                 const MergeOptions& options) {
  const Vec3 &p = cloud.points[i], &n = cloud.normals[i];
  const double own = std::max<double>(cloud.sigma[i], 1e-9), cosine = std::cos(options.max_normal_angle);
  struct Sums {
    double weight = 0, shift = 0, variance = 0;
    Vec3 normal = Vec3::Zero();
  };
  std::map<std::int32_t, Sums> views;
  for (const auto k : samples) {
    const double facing = cloud.normals[k].dot(n);
    if (!(facing > cosine)) continue;
    const double sigma = std::max<double>(cloud.sigma[k], 1e-9);
    const double shift = cloud.normals[k].dot(cloud.points[k] - p) / facing;  // to the tangent plane of the other
    if (std::abs(shift) > options.max_sigmas * std::hypot(own, sigma)) continue;
    const double weight = 1 / (sigma * sigma);
    Sums& v = views[cloud.view[k]];
    v.weight += weight, v.shift += weight * shift, v.variance += weight * sigma * sigma,
        v.normal += weight * cloud.normals[k];
  }
  Mean mean;
  double total = 0;
  for (const auto& [view, v] : views) {
    const double weight = v.weight / v.variance;  // one over the mean variance of the view's samples
    total += weight, mean.shift += weight * v.shift / v.weight, mean.normal += weight * v.normal.normalized();
  }
  if (!(total > 0)) return {0, own, n};
  mean.shift /= total, mean.sigma = 1 / std::sqrt(total);
  mean.normal.normalize();
  return mean;
}

}  // namespace

MergedCloud merge_views(const PointCloud& cloud, const MergeOptions& options, Context& context) {
  const std::size_t n = cloud.size();
  ensure(cloud.normals.size() == n && cloud.sigma.size() == n && cloud.view.size() == n,
         "merging needs normals, sigma and view");
  MergedCloud merged;
  std::vector<std::uint32_t> usable;
  for (std::size_t i = 0; i < n; ++i)
    if ((cloud.rejected.size() != n || !cloud.rejected[i]) && cloud.points[i].allFinite())
      usable.push_back(static_cast<std::uint32_t>(i));
  merged.first.push_back(0);
  if (usable.empty()) return merged;
  merged.spacing = options.spacing > 0 ? options.spacing : view_spacing(cloud, usable);
  if (!(merged.spacing > 0)) merged.spacing = 1e-9 + cloud.bounds().diagonal();
  std::vector<std::uint32_t> order = usable;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return cloud.sigma[a] < cloud.sigma[b]; });
  Disks disks(cloud, merged.spacing, usable.size());
  std::vector<Vec3> places;
  for (const auto i : usable) places.push_back(cloud.points[i]);
  const KdTree tree(places);
  std::vector<Neighbour> near;
  std::vector<std::uint32_t> accepted;
  for (const auto i : order)
    if (disks.nearest(i, merged.spacing) < 0 && confirmed(cloud, tree, usable, i, 2 * merged.spacing, options, near))
      disks.add(i), accepted.push_back(i);
  if (context.cancelled) return merged;
  std::sort(accepted.begin(), accepted.end());
  // Every sample stands behind the nearest accepted one.
  std::vector<std::int64_t> behind(n, -1);
  parallel_for(usable.size(), context.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) behind[usable[k]] = disks.nearest(usable[k], 1.0001 * merged.spacing);
  });
  std::vector<std::uint32_t> place(n, 0);
  for (std::size_t a = 0; a < accepted.size(); ++a) place[accepted[a]] = static_cast<std::uint32_t>(a);
  merged.first.assign(accepted.size() + 1, 0);
  for (const auto i : usable)
    if (behind[i] >= 0) ++merged.first[place[static_cast<std::size_t>(behind[i])] + 1];
  std::partial_sum(merged.first.begin(), merged.first.end(), merged.first.begin());
  merged.sample.resize(merged.first.back());
  std::vector<std::uint32_t> next(merged.first.begin(), merged.first.end() - 1);
  for (const auto i : usable)
    if (behind[i] >= 0) merged.sample[next[place[static_cast<std::size_t>(behind[i])]]++] = i;

  PointCloud& out = merged.cloud;
  const std::size_t count = accepted.size();
  out.points.resize(count), out.normals.resize(count), out.sigma.resize(count);
  parallel_for(count, context.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> samples;
    for (std::size_t a = begin; a < end; ++a) {
      const std::uint32_t i = accepted[a];
      samples.assign(merged.sample.begin() + merged.first[a], merged.sample.begin() + merged.first[a + 1]);
      const Mean mean =
          disks.known(i) ? mean_around(cloud, i, samples, options) : Mean{0, cloud.sigma[i], Vec3::Zero()};
      out.points[a] = cloud.points[i] + mean.shift * cloud.normals[i];
      out.normals[a] = mean.normal, out.sigma[a] = static_cast<float>(mean.sigma);
    }
  });
  for (const auto i : accepted) {
    out.view.push_back(cloud.view[i]);
    if (cloud.rays.size() == n) out.rays.push_back(cloud.rays[i]);
    if (cloud.pixel.size() == n) out.pixel.push_back(cloud.pixel[i]);
  }
  return merged;
}

}  // namespace partscribe::scan
