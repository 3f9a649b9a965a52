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

/// Looks for a step of a turned part beyond its last face. `places`: radius (x) and height (y) about the axis of all
/// points that belong to nothing else; `from`: the height at which the rest of the part ends; `sign`: the direction in
/// which the step would lie. The wall of the step is a window of radii, five sigmas of the noise wide. It must hold
/// more of the places than the best of all such windows would hold by chance if the places were outliers, spread evenly
/// over the room beyond `from` (Chernoff's bound, odds of a thousand). Nothing if no window with at least `least`
/// places does.
std::optional<SparseStep> step_beyond(const std::vector<Vec2>& places, double from, double sign, double noise,
                                      std::size_t least);

}  // namespace partscribe::fit
