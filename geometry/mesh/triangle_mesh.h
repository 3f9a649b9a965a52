/// An indexed triangle mesh and the questions about it that need no search tree.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::geometry {

/// Triangles are counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  bool empty() const { return triangles.empty(); }
  Vec3 corner(std::size_t triangle, int k) const { return vertices[triangles[triangle][k]]; }
  Box3 bounds() const;
};

/// How well a mesh bounds a solid.
struct MeshTopology {
  std::size_t boundary_edges = 0;      ///< edges with one triangle
  std::size_t nonmanifold_edges = 0;   ///< edges with more than two
  std::size_t inconsistent_edges = 0;  ///< two triangles that run through the edge in the same direction
  std::size_t components = 0;          ///< connected through edges
  bool closed() const { return boundary_edges == 0 && nonmanifold_edges == 0 && inconsistent_edges == 0; }
};

MeshTopology topology(const TriangleMesh& mesh);
double area(const TriangleMesh& mesh);
/// Signed volume; positive for a closed mesh whose triangles face outward.
double volume(const TriangleMesh& mesh);
/// Area-weighted (angle-weighted) vertex normals; zero for vertices without triangles.
std::vector<Vec3> vertex_normals(const TriangleMesh& mesh);
/// Unites vertices that are equal to the last bit after rounding to `tolerance` (0: exactly equal ones),
/// drops triangles that collapse and vertices that nobody uses. Keeps the order of first use.
TriangleMesh welded(const TriangleMesh& mesh, double tolerance);
/// `mesh` moved by `pose`.
TriangleMesh transformed(const TriangleMesh& mesh, const Pose& pose);
/// Unit normal of a triangle; zero if it has no area.
Vec3 triangle_normal(const TriangleMesh& mesh, std::size_t triangle);

}  // namespace partscribe::geometry
