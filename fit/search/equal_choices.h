/// Which of several equals to take: the one nearest to the scan's own axes, far from where noise could make it another.
#pragma once

#include <array>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::fit {

/// Of directions that serve as well as each other, the index of the one nearest to the scan's axis `order[0]`; of those
/// that are about as near, the one nearest to the next.
std::size_t nearest_to_scan(const std::vector<Vec3>& directions, const std::array<int, 3>& order = {2, 0, 1});

/// `direction` or its opposite.
Vec3 nearest_sense(const Vec3& direction, const std::array<int, 3>& order = {2, 0, 1});

/// Indices of places that nothing else puts in order: by x, of those within `slack` of each other by y.
std::vector<std::size_t> in_order(const std::vector<Vec2>& places, double slack);

/// Indices by falling size; sizes that differ by less than `slack` from the largest of them count as equal, and follow
/// each other as `order` has them.
std::vector<std::size_t> by_size(const std::vector<double>& sizes, const std::vector<std::size_t>& order, double slack);

}  // namespace partscribe::fit
