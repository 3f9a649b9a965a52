/// Who takes part: every way of leaving triangles out, behind one function each.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"

namespace bench {

using namespace partscribe::geometry;

struct Simplified {
  TriangleMesh mesh;
  double seconds = 0;  ///< of processor time, without the translation into the library's own mesh and back
};

/// What a contestant can be told.
enum class Knob {
  tolerance,  ///< mm, a promise: it is told the tolerance and not asked again
  count,      ///< triangles that may be left
  error,      ///< mm of a measure of its own
};

struct Contestant {
  std::string name, version;
  Knob knob = Knob::count;
  std::function<Simplified(const TriangleMesh& mesh, double setting)> run;  ///< empty: not installed
  bool locks_border = false;                                                ///< and is not asked about closed meshes
};

double processor_seconds();

Contestant ours();
std::vector<Contestant> cgal_simplifiers();
std::vector<Contestant> openmesh_simplifiers();
std::vector<Contestant> meshoptimizer_simplifiers();
std::vector<Contestant> pmp_simplifiers();

}  // namespace bench
