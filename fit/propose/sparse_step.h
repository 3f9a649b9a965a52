/// A step of a turned part that so few points show that they were taken for outliers.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::fit {

/// A straight wall about the axis that starts where the rest of the part ends.
struct SparseStep {
  double radius = 0, end = 0;  ///< mm
  std::size_t points = 0;
};

/// `places`: radii (x) and heights (y) about the axis of what belongs to nothing else; `from`: the height at which the
/// rest of the part ends, beyond which, towards `sign`, the step would lie. Its wall is the window, five sigmas of the
/// noise wide, that holds more of the places beyond than outliers strewn evenly through that room put into the best of
/// all windows (Chernoff's bound, odds of a thousand). Nothing if there is none with `least` places.
std::optional<SparseStep> step_beyond(const std::vector<Vec2>& places, double from, double sign, double noise,
                                      std::size_t least);

}  // namespace partscribe::fit
