/// The ten surfaces of the measurement, each with a tolerance: made ones, and scans from files.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "geometry/mesh/triangle_mesh.h"

namespace bench {

using namespace partscribe::geometry;

/// One question: a manifold mesh, and how far the answer may be from it.
struct TriangleSet {
  std::string name;
  TriangleMesh mesh;
  double tolerance = 0;              ///< mm, both ways
  double spacing = 0;                ///< mm between the places at which distances are measured
  std::optional<double> least;       ///< triangles that any mesh with its vertices on the surface has
  std::optional<double> least_free;  ///< the same where vertices may leave the surface
};

/// How a set is come by; `file` names what has to be given for it, empty: it is made.
struct SetMaker {
  std::string name, file;
  std::function<partscribe::core::Result<TriangleSet>(const std::string& path)> make;
};

const std::vector<SetMaker>& set_makers();

}  // namespace bench
