/// Damages of features: holes and bosses that are extra, doubled or of the wrong depth, edges rounded, walls tapered,
/// sheets and bodies that do not belong; for the .cpp files behind mutate.h only.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "verify/mutate/mutate_edits.h"
#include "verify/mutate/mutate_gauge.h"

namespace partscribe::verify {

/// A damage by size: nothing where there is no such model.
struct SizedEdit {
  Mutation::Kind kind;
  std::string name;
  double start = 0;    ///< mm, a first guess
  bool exact = false;  ///< `start` is right if it moves the surface at all visibly
  std::function<std::optional<Model>(double size)> change;
};

/// Damages that add surface where there is none, or fill a hole: large against the tolerance and against the spacing
/// of a few thousand points on the part.
std::vector<Edit> additions(const Model& model, const Gauge& gauge);

/// Damages that are to move the surface by 2 T or, where only an edge changes, by more: rounded edges, tapered walls, a
/// hole of its own diameter, the part together with its shifted copy.
std::vector<SizedEdit> sized_edits(const Model& model);

}  // namespace partscribe::verify
