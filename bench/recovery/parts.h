/// Random parts of every kind, none of them nearly another kind.
#pragma once

#include <string>
#include <vector>

#include "core/random.h"
#include "geometry/triangle_mesh.h"
#include "model/model.h"

namespace partscribe::recovery {

struct Part {
  Model model;   ///< in its own frame
  Box3 bounds;   ///< exact
};

/// Sizes between some 20 and 100 mm; no two kinds' parts can be told apart by less than a tenth of their size.
Part random_part(const std::string& kind, Random& random);

}  // namespace partscribe::recovery
