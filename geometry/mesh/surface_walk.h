/// Walks on a mesh along straight lines beside it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/mesh/mesh_neighbours.h"
#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::geometry {

/// A place inside a triangle.
struct SurfacePlace {
  std::uint32_t triangle = 0;
  Vec3 point = Vec3::Zero();
};

enum class Walk {
  within,
  beyond,  ///< too far away, or it missed the end
  ended    ///< at a border
};

class SurfaceWalk {
 public:
  /// `mesh` is manifold and consistently oriented, and outlives it.
  explicit SurfaceWalk(const TriangleMesh& mesh);

  std::uint32_t across(std::uint32_t t, int k) const { return across_[t][k]; }  ///< no_neighbour at a border
  const Vec3& normal(std::uint32_t t) const { return normals_[t]; }             ///< unit, or zero without area

  /// The nearby place that lies inside the triangle, off its edges.
  SurfacePlace inside(std::uint32_t t, const Vec3& p) const;

  /// Goes from one place to another in the plane of both and of the normals there, and asks for the distance of the
  /// segment from a to b at each edge that it crosses. Where all are within `bound`, and so are the ends, the segment
  /// and the way are within it of each other everywhere: each piece lies in one triangle, and the distance from what
  /// is convex is greatest at an end.
  Walk along(const Vec3& a, const SurfacePlace& from, const Vec3& b, const SurfacePlace& to, double bound) const;

 private:
  const TriangleMesh& mesh_;
  std::vector<std::array<std::uint32_t, 3>> across_;
  std::vector<Vec3> normals_;
};

}  // namespace partscribe::geometry
