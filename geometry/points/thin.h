/// Even thinning of a cloud whose result depends on the coordinates only, never on their order in a file.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::geometry {

/// All indices, sorted by x, then y, then z (then by index, for points that coincide).
std::vector<std::uint32_t> coordinate_order(const std::vector<Vec3>& points);

/// One point for every cube of edge `spacing` (mm) that holds any: the one nearest to their centroid. Rejected points
/// (`rejected` is empty or as long as `points`) and undefined ones are left out. Sorted by cube; `spacing` 0 keeps all
/// points, in coordinate order.
std::vector<std::uint32_t> thinned(const std::vector<Vec3>& points, const std::vector<std::uint8_t>& rejected,
                                   double spacing);

/// The spacing at which thinned() keeps just at most `target` points; 0 where all of them are few enough.
double spacing_for_count(const std::vector<Vec3>& points, std::size_t target);
double spacing_for_count(const std::vector<Vec3>& points, const std::vector<std::uint8_t>& rejected,
                         std::size_t target);

}  // namespace partscribe::geometry
