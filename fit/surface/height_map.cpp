#include "fit/surface/height_map.h"

#include <algorithm>
#include <array>

namespace partscribe::fit {
namespace {

constexpr std::size_t least_lines = 4;

/// Values, ascending, each farther from the one before than `same`.
std::vector<double> apart_by_more(std::vector<double> values, double same) {
  std::ranges::sort(values);
  std::vector<double> result;
  for (const double value : values)
    if (result.empty() || value - result.back() > same) result.push_back(value);
  return result;
}

std::size_t place_in(const std::vector<double>& list, double value, double same) {
  return std::size_t(std::ranges::upper_bound(list, value + same) - list.begin()) - 1;
}

std::optional<SplineGrid> map_along(const PointCloud& cloud, int up, const std::array<std::vector<double>, 3>& lines,
                                    double same) {
  const int u = (up + 1) % 3, v = (up + 2) % 3;
  SplineGrid grid{lines[std::size_t(u)], lines[std::size_t(v)], {}};
  if (std::min(grid.u.size(), grid.v.size()) < least_lines || grid.u.size() * grid.v.size() != cloud.size())
    return std::nullopt;
  std::vector<char> taken(cloud.size(), 0);
  grid.points.resize(cloud.size());
  for (const Vec3& p : cloud.points) {
    const std::size_t at = place_in(grid.u, p[u], same) * grid.v.size() + place_in(grid.v, p[v], same);
    if (taken[at]) return std::nullopt;
    taken[at] = 1, grid.points[at] = p;
  }
  return grid;
}

}  // namespace

std::optional<SplineGrid> height_map_of(const PointCloud& cloud) {
  if (cloud.size() < least_lines * least_lines) return std::nullopt;
  if (std::ranges::any_of(cloud.rejected, [](auto flag) { return flag != 0; })) return std::nullopt;
  const double same = 1e-7 * cloud.bounds().diagonal();
  std::array<std::vector<double>, 3> lines;
  for (const int axis : {0, 1, 2}) {
    std::vector<double> values;
    for (const Vec3& p : cloud.points) values.push_back(p[axis]);
    lines[std::size_t(axis)] = apart_by_more(std::move(values), same);
  }
  for (const int up : {2, 1, 0})
    if (auto grid = map_along(cloud, up, lines, same)) return grid;
  return std::nullopt;
}

}  // namespace partscribe::fit
