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
  int passes = 3;                    ///< later ones retry collapses that their surroundings forbade before
};

/// `mesh` is manifold (see repair()) and stays so: closed stays closed, borders stay borders, nothing turns over.
/// Where nothing can be collapsed the result is the mesh itself.
TriangleMesh decimated(const TriangleMesh& mesh, const DecimateOptions& options, Context& context);

/// The nearest point of a triangle.
Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace partscribe::geometry
