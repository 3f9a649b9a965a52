/// Three parts of together 44 primitives, whose every face is known.
#pragma once

#include <string>
#include <vector>

#include "bench/faces/truth.h"

namespace bench {

struct Part {
  std::string name;
  Truth truth;  ///< meshed far below the noise
};

/// A flange of 14 faces, a bracket of 15 and a housing of 15, of 60 to 90 mm: 19 planes, 18 cylinders, 4 cones, a
/// sphere, 2 tori.
std::vector<Part> parts();

}  // namespace bench
