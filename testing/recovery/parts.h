/// Random parts of every kind, none of them nearly another kind, and a few that are.
#pragma once

#include <string>
#include <vector>

#include "core/random.h"
#include "geometry/mesh/triangle_mesh.h"
#include "model/model.h"

namespace partscribe::testing::recovery {

using namespace model;

struct Part {
  Model model;     ///< in its own frame
  Box3 bounds;     ///< exact
  double arc = 0;  ///< rad; only places this far around z, about x, can be seen; 0: all
};

/// Sizes between some 20 and 100 mm; no two kinds' parts can be told apart by less than a tenth of their size.
Part random_part(const std::string& kind, Random& random);

/// The degenerate ones: "cone_1deg" (half angle), "cylinder_30deg" (of its arc seen), "torus_fat" (tube over ring above
/// 0.9), "torus_patch" (a tenth of its outer side seen), "ellipsoid_round" (half axes within 3 %).
Part degenerate_part(const std::string& kind, Random& random);

}  // namespace partscribe::testing::recovery
