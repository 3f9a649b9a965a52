/// Which of a few thousand points is about the nearest, looked up instead of searched for.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::geometry {

/// A grid over the box of the points; each of its cells knows the point nearest to its middle, within about a cell.
class NearestMap {
 public:
  /// `points`: at least one, all finite. Cells have edges of `cell` (mm), or larger ones where more than `most_cells`
  /// would be needed.
  NearestMap(const std::vector<Vec3>& points, double cell, std::size_t most_cells = 32768);

  /// Outside the box: what is near the nearest place of it.
  std::uint32_t near(double x, double y, double z) const {
    return index_[place(x, 0) + static_cast<std::size_t>(count_[0]) *
                                    (place(y, 1) + static_cast<std::size_t>(count_[1]) * place(z, 2))];
  }

  double cell() const { return cell_; }

 private:
  std::size_t place(double at, int axis) const {
    const double k = (at - low_[axis]) * inverse_;
    return static_cast<std::size_t>(k > 0 ? (k < last_[axis] ? k : last_[axis]) : 0);
  }
  double cell_, inverse_;
  double low_[3], last_[3];
  int count_[3];
  std::vector<std::uint32_t> index_;
};

}  // namespace partscribe::geometry
