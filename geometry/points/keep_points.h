/// Points chosen from a cloud, with everything that is known of them.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/points/point_cloud.h"

namespace partscribe::geometry {

/// Drops every entry i with keep[i] == 0; the others keep their order. An empty column stays empty, others are as long
/// as `keep`.
template <class T>
void keep_entries(std::vector<T>& column, const std::vector<std::uint8_t>& keep) {
  if (column.empty()) return;
  std::size_t to = 0;
  for (std::size_t i = 0; i < keep.size(); ++i)
    if (keep[i]) column[to++] = column[i];
  column.resize(to);
}

/// Drops every point i with keep[i] == 0 from all columns; `keep` is as long as the cloud. The others keep their order.
void keep_points(PointCloud& cloud, const std::vector<std::uint8_t>& keep);

/// 1 for every point whose coordinates are those of one of `places`, 0 for the others.
std::vector<std::uint8_t> points_at(const PointCloud& cloud, std::vector<Vec3> places);

}  // namespace partscribe::geometry
