#include "geometry/points/nearest_again.h"

#include <algorithm>
#include <cmath>

namespace partscribe::geometry {

std::uint32_t NearestAgain::nearest(std::size_t k, const Vec3& place, double limit) {
  constexpr double rounded = 1 - 1e-9;  // so that no rounding makes another point the nearest
  constexpr double room = 1.25;         // looked for beyond the limit, for the next times
  Last& last = last_[k];
  const auto sq_to = [&](std::uint32_t i) {
    const Vec3& p = (*points_)[i];
    const double x = place.x() - p.x(), y = place.y() - p.y(), z = place.z() - p.z();
    return x * x + y * y + z * z;
  };
  const double x = place.x() - last.x, y = place.y() - last.y, z = place.z() - last.z;
  const double sq_moved = x * x + y * y + z * z;
  if (last.first != nobody) {
    if (sq_moved < last.slack * last.slack && last.slack > 0)
      return sq_to(last.first) <= limit * limit ? last.first : nobody;
  } else if (std::sqrt(sq_moved) + limit < last.slack) {
    return nobody;
  }
  PixelGrid::Found found;
  if (grid_ && grid_->nearest(place, limit, found)) {
    last = {place.x(), place.y(), place.z(), found.others * rounded, found.first, found.second};
    if (found.first == nobody) return nobody;
    last.slack = 0.5 * (last.slack - std::sqrt(found.sq_first));
    return found.sq_first <= limit * limit ? found.first : nobody;
  }
  const double sq_room = room * limit * room * limit;
  double sq_limit = sq_room;
  if (last.second != nobody) sq_limit = std::min(sq_limit, std::max(sq_to(last.first), sq_to(last.second)));
  const auto [first, second] = tree_->nearest_two(place, sq_limit);
  last = {place.x(), place.y(), place.z(), room * limit * rounded, nobody, nobody};
  if (!std::isfinite(first.sq_distance)) return nobody;
  last.first = first.index;
  if (std::isfinite(second.sq_distance)) last.second = second.index;
  last.slack = 0.5 * (std::sqrt(std::min(second.sq_distance, sq_room)) * rounded - std::sqrt(first.sq_distance));
  return first.sq_distance <= limit * limit ? first.index : nobody;
}

}  // namespace partscribe::geometry
