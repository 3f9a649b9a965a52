#include "verify/compare/clusters.h"

#include <algorithm>

#include "core/disjoint_sets.h"
#include "geometry/points/kd_tree.h"

namespace partscribe::verify {
namespace {

constexpr std::size_t neighbours = 24;  // more links would join nothing that these do not

}  // namespace

std::vector<std::vector<std::uint32_t>> clusters_of(const std::vector<Vec3>& places, const std::vector<double>& reach,
                                                    const std::function<bool(std::uint32_t, std::uint32_t)>& alike) {
  std::vector<std::vector<std::uint32_t>> result;
  if (places.empty()) return result;
  DisjointSets sets(places.size());
  const KdTree tree(places);
  std::vector<Neighbour> near;
  for (std::uint32_t i = 0; i < places.size(); ++i) {
    tree.nearest(places[i], neighbours, near);
    for (const auto& n : near) {
      const double limit = std::min(reach[i], reach[n.index]);
      if (n.index != i && n.sq_distance <= limit * limit && alike(i, n.index)) sets.unite(i, n.index);
    }
  }
  std::vector<std::uint32_t> number(places.size(), 0);
  for (std::uint32_t i = 0; i < places.size(); ++i) {
    if (sets.root(i) == i) number[i] = static_cast<std::uint32_t>(result.size()), result.emplace_back();
    result[number[sets.root(i)]].push_back(i);
  }
  return result;
}

}  // namespace partscribe::verify
