#include "geometry/points/kd_leaves.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "core/random.h"

using namespace partscribe::geometry;

namespace {

std::vector<Instructions> runnable() {
  std::vector<Instructions> all;
  for (const auto set : {Instructions::baseline, Instructions::avx2, Instructions::avx512})
    if (set <= widest_instructions()) all.push_back(set);
  return all;
}

}  // namespace

TEST_CASE("kd leaves: the place of a candidate is how many are nearer, whatever the instructions") {
  Random random(3);
  for (const Instructions instructions : runnable())
    for (std::size_t size = 1; size <= 70; ++size)
      for (const bool ties : {false, true}) {
        INFO("instructions " << int(instructions) << ", " << size << " candidates"
                             << (ties ? ", some equally far" : ""));
        KdCandidates c;
        c.size = size;
        for (std::size_t k = 0; k < size; ++k)
          c.sq_distance.push_back(ties ? double(random.below(30)) : random.uniform()),
              c.index.push_back(std::uint32_t(k));
        const std::vector<double> all = c.sq_distance;
        const bool distinct = rank_candidates(c, instructions);
        bool alike = false, right = true;
        for (std::size_t k = 0; k < size; ++k) {
          alike |= std::count(all.begin(), all.end(), all[k]) > 1;
          right &= c.place[k] == std::count_if(all.begin(), all.end(), [&](double d) { return d < all[k]; });
        }
        CHECK(right);
        CHECK(distinct == !alike);
      }
}

TEST_CASE("kd leaves: all points within reach are found, leaf by leaf, whatever the instructions") {
  constexpr std::size_t count = 21;
  Random random(5);
  std::vector<KdLeaf> leaves(count);
  KdBoxes boxes;
  for (std::uint32_t l = 0; l < count; ++l) {
    double low[3], high[3];
    for (int a = 0; a < 3; ++a) low[a] = std::numeric_limits<double>::infinity(), high[a] = -low[a];
    for (std::size_t k = 0; k < KdLeaf::size; ++k) {
      const double p[3] = {0.1 * l + random.uniform(), random.uniform(), random.uniform()};
      leaves[l].x[k] = p[0], leaves[l].y[k] = p[1], leaves[l].z[k] = p[2],
      leaves[l].index[k] = std::uint32_t(100 * l + k);
      for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], p[a]), high[a] = std::max(high[a], p[a]);
    }
    boxes.add(low, high, l);
  }
  boxes.fill_up();
  const Vec3 query(1, 0.5, 0.4);
  for (const double limit : {0.0, 0.05, 0.6, 100.0}) {
    std::vector<std::uint32_t> truth;
    for (const KdLeaf& leaf : leaves) {
      double sq[KdLeaf::size];
      leaf.sq_distances(query, sq);
      for (std::size_t k = 0; k < KdLeaf::size; ++k)
        if (sq[k] <= limit) truth.push_back(leaf.index[k]);
    }
    for (const Instructions instructions : runnable()) {
      KdCandidates found;
      points_within(leaves.data(), boxes, query, limit, found, instructions);
      found.index.resize(found.size);
      CHECK(found.index == truth);
    }
  }
}
