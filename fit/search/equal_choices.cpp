#include "fit/search/equal_choices.h"

#include <algorithm>

namespace partscribe::fit {

std::size_t nearest_to_scan(const std::vector<Vec3>& directions, const std::array<int, 3>& order) {
  // Of the cosine: hundreds of times what noise does to a direction, and small beside what sets the axes of a part
  // apart.
  constexpr double about_as_near = 0.1;
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < directions.size(); ++i) left.push_back(i);
  for (const int axis : order) {
    double most = -2;
    for (const std::size_t i : left) most = std::max(most, directions[i][axis]);
    std::erase_if(left, [&](std::size_t i) { return directions[i][axis] < most - about_as_near; });
  }
  return left.empty() ? 0 : left.front();
}

Vec3 nearest_sense(const Vec3& direction, const std::array<int, 3>& order) {
  return nearest_to_scan({direction, -direction}, order) == 0 ? direction : Vec3(-direction);
}

std::vector<std::size_t> in_order(const std::vector<Vec2>& places, double slack) {
  std::vector<std::size_t> left, result;
  for (std::size_t i = 0; i < places.size(); ++i) left.push_back(i);
  while (!left.empty()) {
    double least = 1e300;
    for (const std::size_t i : left) least = std::min(least, places[i].x());
    auto best = left.end();
    for (auto i = left.begin(); i != left.end(); ++i)
      if (places[*i].x() <= least + slack && (best == left.end() || places[*i].y() < places[*best].y())) best = i;
    result.push_back(*best);
    left.erase(best);
  }
  return result;
}

std::vector<std::size_t> by_size(const std::vector<double>& sizes, const std::vector<std::size_t>& order,
                                 double slack) {
  std::vector<std::size_t> left = order, result;
  while (!left.empty()) {
    double most = -1e300;
    for (const std::size_t i : left) most = std::max(most, sizes[i]);
    for (const std::size_t i : left)
      if (sizes[i] >= most - slack) result.push_back(i);
    std::erase_if(left, [&](std::size_t i) { return sizes[i] >= most - slack; });
  }
  return result;
}

}  // namespace partscribe::fit
