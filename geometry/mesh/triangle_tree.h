/// A bounding-volume tree over triangles with eight children per node, laid out for vector instructions.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "geometry/instructions.h"
#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::geometry {

inline constexpr std::uint32_t no_triangle = std::numeric_limits<std::uint32_t>::max();

/// The best place of a search so far.
struct NearestSlot {
  double sq_distance = std::numeric_limits<double>::max();  ///< what is farther does not count
  std::uint32_t triangle = no_triangle;                     ///< of the mesh
  std::uint32_t leaf = no_triangle;                         ///< the reference of its leaf
  std::uint32_t lane = 0;                                   ///< its place there
};

/// Boxes are single precision and rounded outward, relative to `origin`; corners keep every bit of the mesh.
struct TriangleTree {
  static constexpr int width = 8;           ///< children of a node, and most triangles of a leaf
  static constexpr int most_pending = 700;  ///< bounds the stack of a descent: its depth is bounded in building

  struct alignas(32) Node {
    float low[3][width], high[3][width];
    std::uint32_t child[width];  ///< index of a node, or with leaf_bit the place of a leaf
    std::uint32_t children;
  };
  /// What precedes the vertices of a leaf. Neighbours share vertices: with each stored once a leaf is less than half
  /// as large as with three per triangle, and memory is what a search in a large mesh waits for.
  struct alignas(64) Leaf {
    std::uint8_t count, vertices;
    std::uint8_t unused[6];
    /// The vertices of each triangle, sorted by place, so that two triangles compute an edge that they share with the
    /// same bits. Lanes from `count` on repeat the last triangle.
    std::uint8_t corner[3][width];
    std::uint32_t triangle[width];  ///< of the mesh, in order

    /// Coordinate k of vertex v stands at k * vertices + v.
    const double* coordinates() const { return reinterpret_cast<const double*>(this + 1); }
  };
  static_assert(sizeof(Leaf) == 64);
  static constexpr std::uint32_t leaf_bit = 1u << 31;
  static bool is_leaf(std::uint32_t ref) { return ref & leaf_bit; }
  static constexpr std::size_t most_triangles = std::size_t(1) << 28;

  Vec3 origin = Vec3::Zero();
  std::vector<Node> nodes;   ///< the first one is the root; none without triangles
  std::vector<Leaf> leaves;  ///< in units of their heads: a leaf is one of them and its vertices behind it

  const Leaf& leaf(std::uint32_t ref) const { return leaves[ref & ~leaf_bit]; }
  /// Corner c, in sorted order, of the triangle where a search ended.
  Vec3 corner(const NearestSlot& at, std::size_t c) const { return corner(leaf(at.leaf), at.lane, c); }
  static Vec3 corner(const Leaf& leaf, std::size_t lane, std::size_t c) {
    const double* x = leaf.coordinates() + leaf.corner[c][lane];
    return {x[0], x[leaf.vertices], x[2 * std::size_t(leaf.vertices)]};
  }
  std::size_t bytes() const;  ///< in use
};

/// The same tree for any number of threads; of a form that suits `instructions`, and searches by others as well.
TriangleTree build_triangle_tree(const TriangleMesh& mesh, int threads,
                                 Instructions instructions = widest_instructions());

/// Improves `best` by every triangle that is nearer, or as near and of lower index in the mesh. The answer depends
/// on the mesh and the query alone: not on the tree, on what `best` held, or on the machine's instructions.
void search_nearest(const TriangleTree& tree, const Vec3& query, NearestSlot& best,
                    Instructions instructions = widest_instructions());

/// Where searches ended: the nearest points of the triangles found.
void nearest_points(const TriangleTree& tree, std::span<const Vec3> queries, const NearestSlot* found, Vec3* points,
                    Instructions instructions = widest_instructions());

struct NearSlot {
  double sq_distance = 0;
  std::uint32_t triangle = 0;
};
/// Appends every triangle no farther than `distance`, in any order.
void triangles_within(const TriangleTree& tree, const Vec3& query, double distance, std::vector<NearSlot>& found);

/// As search_nearest for each query from nothing. The closer together those lie that follow each other, the less time
/// each takes: they share their way down the tree, and what one waits for the others do not.
/// Every query must be finite.
void search_nearest(const TriangleTree& tree, std::span<const Vec3> queries, NearestSlot* best,
                    Instructions instructions = widest_instructions());

/// `best` as if the leaf of `hint` were all there is; a good start for a query close to the one that ended in `hint`.
NearestSlot start_from(const TriangleTree& tree, const Vec3& query, const NearestSlot& hint);

}  // namespace partscribe::geometry
