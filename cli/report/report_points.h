/// Which of a million points a page shows: those that keep the structure and the extremes of the deviation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::cli {

struct ShownPoints {
  std::vector<std::uint32_t> index;  ///< of the points shown, ascending
  std::size_t of = 0;                ///< points that had a value
  double value_error = 0;            ///< no point differs by more than this from the shown one that stands for it
  double distance = 0;               ///< mm, no point is farther than this from the shown one that stands for it
};

/// At most `most` of the points whose value is finite. Space is cut into cells, first where the values within a cell
/// differ most in units of `scale` or the cell is large; one point stands for a cell. The extremes of the values are
/// always shown. Does not depend on the order of the points.
ShownPoints shown_points(const std::vector<Vec3>& points, const std::vector<float>& values, double scale,
                         std::size_t most);

}  // namespace partscribe::cli
