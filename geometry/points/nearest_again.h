/// The nearest points to queries that are asked again and again while they move little.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "geometry/images/pixel_grid.h"
#include "geometry/points/kd_tree.h"

namespace partscribe::geometry {

/// Remembers for every query where it was asked last and how far it may move from there without another answer: half of
/// what the second nearest is farther away (Greenspan & Godin 2001). Answers are those of the tree, always.
class NearestAgain {
 public:
  static constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();

  /// `tree` is over `points`, and so is `grid` if there is one, which is asked first; all stay with the caller.
  NearestAgain(const KdTree& tree, const std::vector<Vec3>& points, std::size_t queries,
               const PixelGrid* grid = nullptr)
      : tree_(&tree), grid_(grid), points_(&points), last_(queries) {}

  /// Index of the point nearest to query `k`, now at `place`; nobody if it is farther than `limit` (mm).
  std::uint32_t nearest(std::size_t k, const Vec3& place, double limit);

 private:
  struct Last {
    double x = 0, y = 0, z = 0;
    double slack = -1;  // without anybody: how far around all is empty
    std::uint32_t first = nobody, second = nobody;
  };
  const KdTree* tree_;
  const PixelGrid* grid_;
  const std::vector<Vec3>* points_;
  std::vector<Last> last_;
};

}  // namespace partscribe::geometry
