#include "geometry/points/bulk_box.h"

#include <algorithm>

namespace partscribe::geometry {

Box3 bulk_box(const std::vector<Vec3>& points, double left_out) {
  Box3 box;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> along;
    along.reserve(points.size());
    for (const Vec3& p : points)
      if (p.allFinite()) along.push_back(p[k]);
    if (along.empty()) return box;
    const auto low = static_cast<std::size_t>(left_out * static_cast<double>(along.size())),
               high = along.size() - 1 - low;
    std::nth_element(along.begin(), along.begin() + static_cast<std::ptrdiff_t>(low), along.end());
    box.low[k] = along[low];
    std::nth_element(along.begin(), along.begin() + static_cast<std::ptrdiff_t>(high), along.end());
    box.high[k] = along[high];
  }
  return box;
}

}  // namespace partscribe::geometry
