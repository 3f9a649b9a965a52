#include "verify/compare/outliers.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/disjoint_sets.h"
#include "core/number.h"
#include "core/parallel.h"
#include "verify/compare/chance.h"

namespace partscribe::verify {
namespace {

constexpr std::array<double, 2> scales = {2.5, 5};   // spacings
constexpr std::array<double, 2> patches = {2, 3.5};  // spacings; the ring reaches three times as far
constexpr std::size_t fewest_in_ring = 30;
// density of the densest curtain of a scan to its share of outliers that stand alone
constexpr double curtain_of_alone = 50;
constexpr double least_curtain = 0.01;
constexpr double densest_over_surface = 0.06;  // share of a patch of scanned surface that curtains from its edges reach
constexpr double usual_share = 0.02;           // of outliers, unless more were announced
constexpr double over_share = 2,
                 most_over_surface =
                     0.4;  // where outliers fill the room about the part: times their share of the points
constexpr double fewest_outliers = 0.001;  // share of the points that is believed to be outliers

/// The window about one point that is least likely by chance.
struct Alarm {
  double probability = 1, expected = 0, radius = 0;
  std::size_t count = 0;
};

class Judge {
 public:
  explicit Judge(const OutlierScene& scene)
      : scene_(scene), off_(scene.off), feet_(scene.feet), spacing_(scene.source->spacing) {
    const auto total = static_cast<double>(std::max<std::size_t>(scene.source->points.size(), 1));
    share_ = std::clamp(static_cast<double>(scene.off.size()) / total, fewest_outliers, scene.most_outliers);
    // Real outliers stand alone for the most part: how many do tells how dense a curtain of them can be.
    std::size_t alone = 0;
    std::vector<Neighbour> near;
    for (const auto& p : scene.off) {
      off_.nearest(p, 2, near);
      alone += near.size() < 2 || near[1].sq_distance > scales[0] * scales[0] * spacing_ * spacing_;
    }
    densest_ = std::clamp(curtain_of_alone * static_cast<double>(alone) / total, least_curtain, densest_curtain);
    over_surface_ = std::min(densest_, densest_over_surface);
    if (share_ > usual_share) over_surface_ = std::max(over_surface_, std::min(over_share * share_, most_over_surface));
  }

  std::vector<OutlierCluster> run(double false_alarm, int threads) const {
    const std::size_t count = scene_.off.size();
    std::vector<Alarm> alarms(count);
    const double limit = 0.5 * false_alarm / static_cast<double>(count);
    parallel_for(
        count, threads,
        [&](std::size_t begin, std::size_t end) {
          std::vector<Neighbour> near, kept;
          for (std::size_t i = begin; i < end; ++i) {
            const Alarm space = in_space(i), surface = on_surface(i, near, kept);
            // Half of the chance of a false alarm each, again shared by the sizes of the windows.
            if (space.probability * double(scales.size()) < limit)
              alarms[i] = space;
            else if (surface.probability * double(patches.size()) < limit)
              alarms[i] = surface;
          }
        },
        64);
    return grouped(alarms);
  }

 private:
  const OutlierScene& scene_;
  KdTree off_, feet_;
  double spacing_, share_ = 0, densest_ = densest_curtain, over_surface_ = densest_over_surface;

  Alarm in_space(std::size_t i) const {
    Alarm best;
    for (const double scale : scales) {
      const double radius = scale * spacing_;
      const std::size_t inside = off_.count_within(scene_.off[i], radius);
      const std::size_t ring = off_.count_within(scene_.off[i], 3 * radius) - inside;
      // Surface would put so many points into a disc of this radius. Outliers line up along edges: of a line through
      // the window's middle, the ring holds twice as much as the window.
      const double area = pi * scale * scale;
      const double expected =
          std::clamp(static_cast<double>(ring + 1) / 2, std::min(share_, densest_) * area, densest_ * area);
      const double chance = poisson_tail(inside - 1, expected);  // besides the point itself
      if (chance < best.probability) best = {chance, expected, radius, inside};
    }
    return best;
  }

  Alarm on_surface(std::size_t i, std::vector<Neighbour>& near, std::vector<Neighbour>& kept) const {
    Alarm best;
    if (feet_.count_within(scene_.feet[i], 3 * patches.back() * spacing_) < 3) return best;
    scene_.source->tree->within(scene_.feet[i], 3 * patches.back() * spacing_, kept);
    off_.within(scene_.off[i], 2 * patches.back() * spacing_, near);
    for (const double size : patches) {
      const double radius = size * spacing_;
      // On edges and corners feet of far-off outliers fall together: those count that are near each other themselves.
      std::size_t off = 0, on = 0, on_ring = 0;
      for (const auto& n : near)
        off += n.sq_distance <= 4 * radius * radius &&
               (scene_.feet[n.index] - scene_.feet[i]).squaredNorm() <= radius * radius;
      const std::size_t off_ring =
          feet_.count_within(scene_.feet[i], 3 * radius) - feet_.count_within(scene_.feet[i], radius);
      for (const auto& n : kept) {
        if (n.sq_distance > 9 * radius * radius) break;
        if ((*scene_.is_off)[n.index]) continue;
        if (n.sq_distance <= radius * radius)
          ++on;
        else
          on_ring += (*scene_.normals)[(*scene_.triangle)[n.index]].dot(scene_.foot_normals[i]) > 0.7;
      }
      if (off < 3 || on_ring < fewest_in_ring) continue;  // not scanned all around: nothing to miss
      const double share = std::clamp(static_cast<double>(off_ring + 1) / static_cast<double>(off_ring + on_ring + 2),
                                      std::min(share_, densest_), over_surface_);
      const double chance = binomial_tail(off, off + on, share);
      if (chance < best.probability) best = {chance, share * static_cast<double>(off + on), radius, off};
    }
    return best;
  }

  /// Windows that overlap become one cluster.
  std::vector<OutlierCluster> grouped(const std::vector<Alarm>& alarms) const {
    DisjointSets sets(alarms.size());
    std::vector<char> taken(alarms.size(), 0);
    std::vector<Neighbour> near;
    for (std::uint32_t i = 0; i < alarms.size(); ++i) {
      if (alarms[i].count == 0) continue;
      off_.within(scene_.off[i], alarms[i].radius, near);
      for (const auto& n : near) {
        taken[n.index] = 1;
        sets.unite(i, n.index);
      }
    }
    std::vector<OutlierCluster> clusters;
    std::vector<std::uint32_t> number(alarms.size(), 0);
    std::vector<double> least;
    std::vector<Box3> boxes;
    for (std::uint32_t i = 0; i < alarms.size(); ++i) {
      if (!taken[i]) continue;
      const auto r = sets.root(i);
      if (r == i)
        number[r] = static_cast<std::uint32_t>(clusters.size()), clusters.emplace_back(), least.push_back(2),
        boxes.emplace_back();
      OutlierCluster& cluster = clusters[number[r]];
      cluster.members.push_back(i);
      boxes[number[r]].add(scene_.off[i]);
      if (alarms[i].count && alarms[i].probability < least[number[r]])
        least[number[r]] = alarms[i].probability, cluster.most = alarms[i].count, cluster.expected = alarms[i].expected;
    }
    for (std::size_t c = 0; c < clusters.size(); ++c) clusters[c].extent = boxes[c].diagonal();
    std::stable_sort(clusters.begin(), clusters.end(), [](const OutlierCluster& a, const OutlierCluster& b) {
      return a.members.size() > b.members.size();
    });
    return clusters;
  }
};

}  // namespace

std::vector<OutlierCluster> clusters_beyond_chance(const OutlierScene& scene, double false_alarm, int threads) {
  if (scene.off.size() < 3 || !(scene.source->spacing > 0)) return {};
  return Judge(scene).run(false_alarm, threads);
}

}  // namespace partscribe::verify
