#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/ensure.h"
#include "geometry/triangle_tree.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define PARTSCRIBE_VECTOR_VERSIONS 1
#include <immintrin.h>
#else
#define PARTSCRIBE_VECTOR_VERSIONS 0
#endif

// Vectors stay inside this file; how they would be passed between files does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace partscribe {
namespace {

namespace baseline {
#define LANES 2
#define BOXES 4
typedef std::int32_t FloatMask __attribute__((vector_size(16)));
typedef std::int64_t RealMask __attribute__((vector_size(16)));
inline unsigned mask_bits(const FloatMask& m) { return (m[0] & 1u) | (m[1] & 2u) | (m[2] & 4u) | (m[3] & 8u); }
inline unsigned mask_bits(const RealMask& m) { return static_cast<unsigned>((m[0] & 1u) | (m[1] & 2u)); }
#include "geometry/search_nearest.inc"
#undef LANES
#undef BOXES
}  // namespace baseline

#if PARTSCRIBE_VECTOR_VERSIONS
#pragma GCC push_options
#pragma GCC target("avx2,bmi")
namespace avx2 {
#define LANES 4
#define BOXES 8
typedef std::int32_t FloatMask __attribute__((vector_size(32)));
typedef std::int64_t RealMask __attribute__((vector_size(32)));
inline unsigned mask_bits(const FloatMask& m) { return static_cast<unsigned>(_mm256_movemask_ps(std::bit_cast<__m256>(m))); }
inline unsigned mask_bits(const RealMask& m) { return static_cast<unsigned>(_mm256_movemask_pd(std::bit_cast<__m256d>(m))); }
#include "geometry/search_nearest.inc"
#undef LANES
#undef BOXES
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512vl,avx512dq,avx2,bmi")
namespace avx512 {
#define LANES 8
#define BOXES 8
typedef std::int32_t FloatMask __attribute__((vector_size(32)));
typedef std::int64_t RealMask __attribute__((vector_size(64)));
inline unsigned mask_bits(const FloatMask& m) { return static_cast<unsigned>(_mm256_movemask_ps(std::bit_cast<__m256>(m))); }
inline unsigned mask_bits(const RealMask& m) { return _mm512_movepi64_mask(std::bit_cast<__m512i>(m)); }
#include "geometry/search_nearest.inc"
#undef LANES
#undef BOXES
}  // namespace avx512
#pragma GCC pop_options
#endif

/// The widest version that this machine runs.
struct Versions {
  decltype(&baseline::search) search = baseline::search;
  decltype(&baseline::search_together) search_together = baseline::search_together;
  decltype(&baseline::leaf) search_leaf = baseline::leaf;
  decltype(&baseline::boxes) boxes_within = baseline::boxes;
  decltype(&baseline::collect) collect = baseline::collect;
  Versions() {
#if PARTSCRIBE_VECTOR_VERSIONS
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq"))
      search = avx512::search, search_together = avx512::search_together, search_leaf = avx512::leaf, boxes_within = avx512::boxes,
      collect = avx512::collect;
    else if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi"))
      search = avx2::search, search_together = avx2::search_together, search_leaf = avx2::leaf, boxes_within = avx2::boxes,
      collect = avx2::collect;
#endif
  }
};

const Versions& versions() {
  static const Versions chosen;
  return chosen;
}

}  // namespace

void search_nearest(const TriangleTree& tree, const Vec3& query, NearestSlot& best) {
  if (!tree.nodes.empty()) versions().search(tree, query, best);
}

void search_nearest(const TriangleTree& tree, const Frontier& frontier, std::span<const Vec3> queries, const NearestSlot* hint,
                    NearestSlot* best) {
  ensure(queries.size() <= Frontier::most_queries, "more queries together than there is room for");
  versions().search_together(tree, frontier, queries.data(), static_cast<int>(queries.size()), hint, best);
}

void triangles_within(const TriangleTree& tree, const Vec3& query, double distance, std::vector<NearSlot>& found) {
  if (!tree.nodes.empty()) versions().collect(tree, query, distance * distance, found);
}

NearestSlot start_from(const TriangleTree& tree, const Vec3& query, const NearestSlot& hint) {
  NearestSlot best;
  if (hint.triangle != no_triangle) versions().search_leaf(tree, query, hint.leaf, best);
  return best;
}

Frontier frontier_of(const TriangleTree& tree, const Box3& queries, double reach) {
  // Boxes are relative to the origin; what is rounded here is covered by a margin.
  double size = 0;
  float low[3], high[3];
  for (int k = 0; k < 3; ++k) {
    const double l = queries.low[k] - tree.origin[k], h = queries.high[k] - tree.origin[k];
    size = std::max({size, std::abs(l), std::abs(h)});
    low[k] = static_cast<float>(l), high[k] = static_cast<float>(h);
  }
  const double far = (reach + 2e-7 * size) * (1 + 1e-6);
  const auto bound = static_cast<float>(far * far);

  struct Entry {
    const TriangleTree::Node* node;
    int lane;
  };
  std::array<Entry, Frontier::most> entries;
  int count = 0, next = 0;
  auto open = [&](const TriangleTree::Node& node) {
    alignas(32) float sq[TriangleTree::width];
    unsigned bits = versions().boxes_within(node, low, high, bound, sq);
    if (count + std::popcount(bits) > Frontier::most) return false;
    for (; bits; bits &= bits - 1) entries[static_cast<std::size_t>(count++)] = {&node, std::countr_zero(bits)};
    return true;
  };
  open(tree.nodes[0]);
  // Level by level, as long as there is room: a node gives way to those of its children that are near enough.
  std::array<Entry, Frontier::most> closed;
  int leaves = 0;
  while (next < count) {
    const Entry entry = entries[static_cast<std::size_t>(next++)];
    if (!TriangleTree::is_leaf(entry.node->child[entry.lane]) && leaves + (count - next) + TriangleTree::width <= Frontier::most) {
      // Room is made by moving what is waiting to the front.
      std::copy(entries.begin() + next, entries.begin() + count, entries.begin());
      count -= next, next = 0;
      open(tree.nodes[entry.node->child[entry.lane]]);
    } else {
      closed[static_cast<std::size_t>(leaves++)] = entry;
    }
  }
  Frontier frontier;
  frontier.used = (leaves + TriangleTree::width - 1) / TriangleTree::width;
  for (int b = 0; b < frontier.used; ++b) {
    TriangleTree::Node& block = frontier.blocks[static_cast<std::size_t>(b)];
    const int children = std::min(TriangleTree::width, leaves - b * TriangleTree::width);
    block.children = static_cast<std::uint32_t>(children);
    for (int lane = 0; lane < TriangleTree::width; ++lane) {
      const Entry entry = closed[static_cast<std::size_t>(std::min(b * TriangleTree::width + lane, leaves - 1))];
      for (int k = 0; k < 3; ++k) {
        block.low[k][lane] = entry.node->low[k][entry.lane];
        block.high[k][lane] = entry.node->high[k][entry.lane];
      }
      block.child[lane] = entry.node->child[entry.lane];
    }
  }
  return frontier;
}

}  // namespace partscribe
