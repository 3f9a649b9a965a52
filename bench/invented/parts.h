/// Ten machined and moulded parts with bores that a scanner sees little of.
#pragma once

#include <string>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::testing {

using namespace geometry;

struct NamedPart {
  std::string name;
  TriangleMesh mesh;
};

std::vector<NamedPart> parts_with_bores();

}  // namespace partscribe::testing
