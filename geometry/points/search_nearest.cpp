#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/ensure.h"
#include "geometry/mesh/triangle_tree.h"

#if PARTSCRIBE_VECTOR_VERSIONS
#include <immintrin.h>
#endif

// Vectors stay inside this file; how they would be passed between files does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace partscribe::geometry {
namespace {

constexpr int most_together = 32;  // queries that share a frontier
constexpr double far = 2;          // times the size of their box: from there queries have the same triangles in view
constexpr int most_in_view = 32;   // boxes of them whose centres are searched together
static_assert(most_in_view <= most_together);

/// The parts of a tree that matter to queries that lie close together.
struct Frontier {
  static constexpr int most = 32;
  alignas(64) float low[3][most], high[3][most];
  alignas(64) std::uint32_t child[most];
  int used;
};

namespace baseline {
#define LANES 2
#define BOXES 4
#define WIDE 4
typedef std::int32_t WideMask __attribute__((vector_size(16)));
typedef std::int32_t FloatMask __attribute__((vector_size(16)));
typedef double RealPair __attribute__((vector_size(16)));
typedef decltype(RealPair{} == RealPair{}) RealMask;
inline unsigned mask_bits(const FloatMask& m) { return (m[0] & 1u) | (m[1] & 2u) | (m[2] & 4u) | (m[3] & 8u); }
inline unsigned mask_bits(const RealMask& m) { return static_cast<unsigned>((m[0] & 1u) | (m[1] & 2u)); }
#include "geometry/points/search_nearest.inc"
#undef LANES
#undef BOXES
#undef WIDE
}  // namespace baseline

#if PARTSCRIBE_VECTOR_VERSIONS
#pragma GCC push_options
#pragma GCC target("avx2,bmi")
namespace avx2 {
#define LANES 4
#define BOXES 8
#define WIDE 8
typedef std::int32_t WideMask __attribute__((vector_size(32)));
typedef std::int32_t FloatMask __attribute__((vector_size(32)));
typedef std::int64_t RealMask __attribute__((vector_size(32)));
inline unsigned mask_bits(const FloatMask& m) {
  return static_cast<unsigned>(_mm256_movemask_ps(std::bit_cast<__m256>(m)));
}
inline unsigned mask_bits(const RealMask& m) {
  return static_cast<unsigned>(_mm256_movemask_pd(std::bit_cast<__m256d>(m)));
}
#include "geometry/points/search_nearest.inc"
#undef LANES
#undef BOXES
#undef WIDE
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512vl,avx512dq,avx2,bmi")
namespace avx512 {
#define LANES 8
#define BOXES 8
#define WIDE 16
typedef std::int32_t WideMask __attribute__((vector_size(64)));
typedef std::int32_t FloatMask __attribute__((vector_size(32)));
typedef std::int64_t RealMask __attribute__((vector_size(64)));
inline unsigned mask_bits(const FloatMask& m) {
  return static_cast<unsigned>(_mm256_movemask_ps(std::bit_cast<__m256>(m)));
}
inline unsigned mask_bits(const WideMask& m) { return _mm512_movepi32_mask(std::bit_cast<__m512i>(m)); }
inline unsigned mask_bits(const RealMask& m) { return _mm512_movepi64_mask(std::bit_cast<__m512i>(m)); }
#include "geometry/points/search_nearest.inc"
#undef LANES
#undef BOXES
#undef WIDE
}  // namespace avx512
#pragma GCC pop_options
#endif

struct Versions {
  decltype(&baseline::search) search;
  decltype(&baseline::search_together) search_together;
  decltype(&baseline::leaf) search_leaf;
  decltype(&baseline::collect) collect;
  decltype(&baseline::feet) feet;
};

const Versions& versions(Instructions instructions) {
#define VERSION(set) \
  { set::search, set::search_together, set::leaf, set::collect, set::feet }
  static constexpr Versions all[] = {PARTSCRIBE_EACH_VERSION(VERSION)};
#undef VERSION
  return all[static_cast<std::size_t>(instructions)];
}

}  // namespace

void search_nearest(const TriangleTree& tree, const Vec3& query, NearestSlot& best, Instructions instructions) {
  if (!tree.nodes.empty()) versions(instructions).search(tree, query, best);
}

void search_nearest(const TriangleTree& tree, std::span<const Vec3> queries, NearestSlot* best,
                    Instructions instructions) {
  if (tree.nodes.empty()) return;
  constexpr std::size_t most = std::size_t(most_together) * most_in_view;
  for (std::size_t i = 0; i < queries.size(); i += most)
    versions(instructions)
        .search_together(tree, queries.data() + i, static_cast<int>(std::min(most, queries.size() - i)), best + i);
}

void nearest_points(const TriangleTree& tree, std::span<const Vec3> queries, const NearestSlot* found, Vec3* points,
                    Instructions instructions) {
  versions(instructions).feet(tree, queries.data(), found, static_cast<int>(queries.size()), points);
}

void triangles_within(const TriangleTree& tree, const Vec3& query, double distance, std::vector<NearSlot>& found) {
  if (!tree.nodes.empty()) versions(widest_instructions()).collect(tree, query, distance * distance, found);
}

NearestSlot start_from(const TriangleTree& tree, const Vec3& query, const NearestSlot& hint) {
  NearestSlot best;
  if (hint.triangle != no_triangle) versions(widest_instructions()).search_leaf(tree, query, hint.leaf, best);
  return best;
}

}  // namespace partscribe::geometry
