/// A bounding-volume tree over triangles with eight children per node, laid out for vector instructions.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace partscribe {

inline constexpr std::uint32_t no_triangle = std::numeric_limits<std::uint32_t>::max();

/// The best place of a search so far.
struct NearestSlot {
  double sq_distance = std::numeric_limits<double>::max();  ///< what is farther does not count
  std::uint32_t slot = no_triangle;
  std::uint32_t first = 0, count = 0;  ///< its leaf
};

/// Boxes are single precision and rounded outward, relative to `origin`; corners keep every bit of the mesh.
struct TriangleTree {
  static constexpr int width = 8;         ///< children of a node, and most triangles of a leaf
  static constexpr int most_pending = 700;  ///< bounds the stack of a descent: its depth is bounded in building

  struct alignas(32) Node {
    float low[3][width], high[3][width];
    std::uint32_t child[width];  ///< index of a node, or leaf_ref
    std::uint32_t children;
  };
  /// A leaf's first slot and its number of triangles in one word.
  static std::uint32_t leaf_ref(std::uint32_t first, std::uint32_t count) { return 1u << 31 | (count - 1) << 28 | first; }
  static bool is_leaf(std::uint32_t ref) { return ref >> 31; }
  static std::uint32_t first_of(std::uint32_t ref) { return ref & ((1u << 28) - 1); }
  static std::uint32_t count_of(std::uint32_t ref) { return (ref >> 28 & 7) + 1; }
  static constexpr std::size_t most_triangles = std::size_t(1) << 28;

  Vec3 origin = Vec3::Zero();
  std::vector<Node> nodes;              ///< the first one is the root; none without triangles
  /// For the leaf of `count` triangles from slot `first`: coordinate k of corner c of its i-th triangle stands at
  /// 9 first + (3 c + k) count + i. The corners of a triangle are sorted, so that two triangles compute an edge that
  /// they share with the same bits.
  std::unique_ptr<double[]> corners;
  std::vector<std::uint32_t> triangle;  ///< of the mesh, by slot

  /// Corner c, in sorted order, of the triangle where a search ended.
  Vec3 corner(const NearestSlot& at, std::size_t c) const {
    const double* x = corners.get() + 9 * std::size_t(at.first) + 3 * c * at.count + (at.slot - at.first);
    return {x[0], x[at.count], x[2 * at.count]};
  }
  std::size_t bytes() const;
};

/// The same tree for any number of threads.
TriangleTree build_triangle_tree(const TriangleMesh& mesh, int threads);

/// Improves `best` by every triangle that is nearer, or as near and of lower index in the mesh. The answer depends
/// on the mesh and the query alone: not on the tree, on what `best` held, or on the machine's instructions.
void search_nearest(const TriangleTree& tree, const Vec3& query, NearestSlot& best);

struct NearSlot {
  double sq_distance = 0;
  std::uint32_t triangle = 0;
};
/// Appends every triangle no farther than `distance`, in any order.
void triangles_within(const TriangleTree& tree, const Vec3& query, double distance, std::vector<NearSlot>& found);

/// The parts of a tree that matter to queries that lie close together.
struct Frontier {
  static constexpr int most = 32;
  static constexpr int most_queries = 32;  ///< that are searched together
  std::array<TriangleTree::Node, most / TriangleTree::width> blocks;  ///< their boxes as if they were children
  int used = 0;
};

/// All within `reach` of a box of queries, as fine as there is room. An answer for a query in the box is complete
/// when it is no farther than `reach`.
Frontier frontier_of(const TriangleTree& tree, const Box3& queries, double reach);

/// As search_nearest for each query from nothing, in these parts only; some of them at once take less time than in turn.
/// `hint`: the answer for a query close by; a good start for queries that are far from the surface and close together.
void search_nearest(const TriangleTree& tree, const Frontier& frontier, std::span<const Vec3> queries, const NearestSlot* hint,
                    NearestSlot* best);

/// `best` as if the leaf of `hint` were all there is; a good start for a query close to the one that ended in `hint`.
NearestSlot start_from(const TriangleTree& tree, const Vec3& query, const NearestSlot& hint);

}  // namespace partscribe
