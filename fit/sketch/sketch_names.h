/// Names for the numbers of a sketch, by the part they play in it.
#pragma once

#include <string>
#include <vector>

#include "fit/sketch/sketch_numbers.h"
#include "fit/sketch/sketch_pieces.h"

namespace partscribe::fit {

/// A note on one thing as it is said of several: "radius of hole 1" is "radius of the holes".
std::string of_several(const std::string& note);

/// Gives the parameters, called "#0", "#1" ... so far, their names and notes by their slots, in expressions as well,
/// and names the faces after them.
void name_parameters(BuiltSketch& built, std::vector<SketchSlot> slots, const std::vector<SketchLevel>& levels,
                     const std::vector<std::vector<SketchPiece>>& pieces, const SketchOptions& options);

}  // namespace partscribe::fit
