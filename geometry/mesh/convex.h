/// The convex polyhedron that half-spaces leave.
#pragma once

#include <optional>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::geometry {

/// The points p with normal . p <= offset; `normal` has unit length.
struct Plane3 {
  Vec3 normal;
  double offset = 0;
};

/// Faces in the order of the planes; each a counter-clockwise polygon seen from outside, empty if its plane only
/// touches the body or misses it.
struct ConvexPolyhedron {
  std::vector<Vec3> vertices;
  std::vector<std::vector<std::uint32_t>> faces;
};

/// Nothing if the intersection is empty, flat or unbounded.
std::optional<ConvexPolyhedron> convex_polyhedron(const std::vector<Plane3>& planes);

/// mm^2.
double face_area(const ConvexPolyhedron& polyhedron, std::size_t face);

/// Each face cut into a fan; face_of[t] is the plane of triangle t.
TriangleMesh triangulated(const ConvexPolyhedron& polyhedron, std::vector<int>* face_of = nullptr);

}  // namespace partscribe::geometry
