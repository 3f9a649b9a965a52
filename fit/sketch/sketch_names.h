/// Names for the numbers of a sketch, by the part they play in it.
#pragma once

#include <vector>

#include "fit/sketch/sketch_numbers.h"
#include "fit/sketch/sketch_pieces.h"

namespace partscribe::fit {

/// Gives the parameters, called "#0", "#1" ... so far, their names and notes by their slots, in expressions as well,
/// and names the faces after them.
void name_parameters(BuiltSketch& built, std::vector<SketchSlot> slots, const std::vector<SketchLevel>& levels,
                     const std::vector<std::vector<SketchPiece>>& pieces, const SketchOptions& options);

}  // namespace partscribe::fit
