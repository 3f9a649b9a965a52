#include "geometry/points/keep_points.h"

#include <algorithm>

#include "core/ensure.h"

namespace partscribe::geometry {

void keep_points(PointCloud& cloud, const std::vector<std::uint8_t>& keep) {
  ensure(keep.size() == cloud.size(), "one mark per point");
  const auto cut = [&](auto& column) { keep_entries(column, keep); };
  cut(cloud.points), cut(cloud.normals), cut(cloud.rays), cut(cloud.sigma), cut(cloud.view), cut(cloud.pixel),
      cut(cloud.rejected);
}

std::vector<std::uint8_t> points_at(const PointCloud& cloud, std::vector<Vec3> places) {
  const auto before = [](const Vec3& a, const Vec3& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::sort(places.begin(), places.end(), before);
  std::vector<std::uint8_t> at(cloud.size());
  for (std::size_t i = 0; i < at.size(); ++i)
    at[i] = std::binary_search(places.begin(), places.end(), cloud.points[i], before);
  return at;
}

}  // namespace partscribe::geometry
