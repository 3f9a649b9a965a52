/// The leaves of a k-d tree, and the inner loops of a search over some of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "geometry/instructions.h"
#include "geometry/vec.h"

namespace partscribe::geometry {

/// Points by coordinate; what is not filled lies at infinity.
struct alignas(64) KdLeaf {
  static constexpr std::size_t size = 16;
  std::array<double, size> x, y, z;
  std::array<std::uint32_t, size> index;

  void sq_distances(const Vec3& p, double* result) const {
    const double px = p.x(), py = p.y(), pz = p.z();
    for (std::size_t k = 0; k < size; ++k) {
      const double dx = px - x[k], dy = py - y[k], dz = pz - z[k];
      result[k] = dx * dx + dy * dy + dz * dz;
    }
  }
};

/// Boxes of leaves by coordinate.
struct KdBoxes {
  static constexpr std::size_t step = 8;  ///< filled up to a multiple of it, at infinity
  std::vector<double> low[3], high[3];
  std::vector<std::uint32_t> leaf;
  std::size_t size = 0;

  void clear() { size = 0; }
  void add(const double* low_corner, const double* high_corner, std::uint32_t number) {
    if (size == leaf.size()) {
      leaf.resize(2 * size + step, 0);
      for (int k = 0; k < 3; ++k) low[k].resize(leaf.size()), high[k].resize(leaf.size());
    }
    for (int k = 0; k < 3; ++k) low[k][size] = low_corner[k], high[k][size] = high_corner[k];
    leaf[size++] = number;
  }
  void fill_up() {
    for (std::size_t b = size; b < leaf.size() && b % step != 0; ++b)
      for (int k = 0; k < 3; ++k) low[k][b] = high[k][b] = std::numeric_limits<double>::infinity();
  }
};

/// Points that may be among the nearest.
struct KdCandidates {
  std::vector<double> sq_distance;
  std::vector<std::uint32_t> index, place;
  std::size_t size = 0;
};

/// All points of the leaves that are not farther than `sq_limit`, which is finite.
void points_within(const KdLeaf* leaves, const KdBoxes& boxes, const Vec3& query, double sq_limit, KdCandidates& found,
                   Instructions instructions = widest_instructions());

/// Fills `place`: how many candidates are nearer than each. True: no two are equally far.
bool rank_candidates(KdCandidates& candidates, Instructions instructions = widest_instructions());

}  // namespace partscribe::geometry
