/// Fewer triangles within a two-sided error bound: quadric edge collapses, each checked against the original surface.
#pragma once

#include <cstdint>
#include <vector>

#include "core/context.h"
#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::geometry {

struct DecimateOptions {
  double max_error = 0.1;            ///< mm; no sample of either surface is farther than this from the other one
  std::size_t target_triangles = 0;  ///< stop here even though more could go
  std::vector<std::uint8_t> frozen;  ///< per vertex, 1: stays where it is; empty: none
  int rounds = 12;                   ///< at most; each but the first relaxes what is left, then collapses again
  int turns = 2;                     ///< of relaxing in a round
  int steps = 2;                     ///< towards a better place where a collapse would leave the bound
};

/// `mesh` is manifold (see repair()) and stays so: closed stays closed, borders stay borders, nothing turns over.
/// Where nothing can be collapsed the result is the mesh itself.
TriangleMesh decimated(const TriangleMesh& mesh, const DecimateOptions& options, Context& context);

}  // namespace partscribe::geometry
