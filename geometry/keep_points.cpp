#include "geometry/keep_points.h"

#include "core/ensure.h"

namespace partscribe {

void keep_points(PointCloud& cloud, const std::vector<std::uint8_t>& keep) {
  ensure(keep.size() == cloud.size(), "one mark per point");
  const auto cut = [&](auto& column) {
    if (column.empty()) return;
    std::size_t to = 0;
    for (std::size_t i = 0; i < keep.size(); ++i)
      if (keep[i]) column[to++] = column[i];
    column.resize(to);
  };
  cut(cloud.points), cut(cloud.normals), cut(cloud.rays), cut(cloud.sigma), cut(cloud.view), cut(cloud.pixel), cut(cloud.rejected);
}

}  // namespace partscribe
