/// Sizes and spacings in a sketch, where a designer would write them instead of coordinates.
#pragma once

#include <array>
#include <vector>

#include "fit/sketch/sketch_numbers.h"
#include "fit/sketch/sketch_pieces.h"

namespace partscribe::fit {

/// The outline (the first loop) from its middle along the axes where that is the origin, holes with straight sides by
/// their size and place, equal holes by their spacing. Sets levels and makes coordinates known.
void place_by_sizes(SketchNumbers& numbers, std::vector<SketchLevel>& levels,
                    const std::vector<std::vector<SketchPiece>>& loops, const std::array<bool, 2>& from_middle);

}  // namespace partscribe::fit
