/// What the triangles of a mesh have one by one and between them: normals, edges, connected pieces.
#pragma once

#include <span>

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::geometry {

/// Unit normals; zero for triangles without area.
std::vector<Vec3> triangle_normals(const TriangleMesh& mesh);

/// mm: how far each triangle lies below the smooth surface that its bends towards its neighbours suggest: chord * angle
/// / 8, summed over its edges. Zero where it is flat; bends of more than 0.7 rad are edges of the part.
std::vector<double> chord_depths(const TriangleMesh& mesh);

/// One side of a triangle.
struct EdgeUse {
  std::uint64_t key;  ///< the edge: the smaller vertex in the high half, the larger in the low
  std::uint32_t triangle;
  std::uint8_t side;  ///< from corner `side` to the next
  bool forward;       ///< from the smaller to the larger vertex

  std::uint32_t low() const { return static_cast<std::uint32_t>(key >> 32); }
  std::uint32_t high() const { return static_cast<std::uint32_t>(key); }
  std::uint32_t from() const { return forward ? low() : high(); }
  std::uint32_t to() const { return forward ? high() : low(); }
};

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b);

/// All sides, those of one edge together, by increasing key and then triangle.
std::vector<EdgeUse> edge_uses(std::span<const std::array<std::uint32_t, 3>> triangles);

/// Calls `visit(around)` for every edge with the sides that lie on it.
template <class Visit>
void for_each_edge(std::span<const EdgeUse> uses, Visit&& visit) {
  for (std::size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
    while (end < uses.size() && uses[end].key == uses[begin].key) ++end;
    visit(uses.subspan(begin, end - begin));
  }
}

/// Turns facets over until neighbours across edges of two agree; each piece keeps the sense of most of its area.
/// Returns how many were turned.
std::size_t orient_facets(TriangleMesh& mesh);

/// Turns all facets of a closed mesh that faces inward; true if it did.
bool turn_outward(TriangleMesh& mesh);

/// How many triangles have no area though their corners differ.
std::size_t flat_facets(const TriangleMesh& mesh);

/// Pieces connected by shared vertices, in the order of their first vertices.
struct MeshPieces {
  std::vector<std::uint32_t> of;  ///< per triangle
  std::vector<double> area;       ///< per piece, mm^2
  std::vector<double> volume;     ///< per piece, mm^3; negative for cavities
};

MeshPieces pieces_of(const TriangleMesh& mesh);

}  // namespace partscribe::geometry
