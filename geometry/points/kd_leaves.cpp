#include "geometry/points/kd_leaves.h"

#include <algorithm>
#include <cstring>

#if PARTSCRIBE_VECTOR_VERSIONS
#include <immintrin.h>
#endif

// Vectors stay inside this file; how they would be passed between files does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace partscribe::geometry {
namespace {

/// Without branches, because which points are kept cannot be predicted.
template <int lanes, class Reals>
__attribute__((always_inline)) inline std::size_t keep_one_by_one(const Reals& d, const Reals& limit,
                                                                  const std::uint32_t* index, double* to,
                                                                  std::uint32_t* from) {
  std::size_t at = 0;
  for (int l = 0; l < lanes; ++l) {
    to[at] = d[l], from[at] = index[l];
    at += d[l] <= limit[l];
  }
  return at;
}

namespace baseline {
#define LANES 2
typedef double Reals __attribute__((vector_size(8 * LANES)));
typedef std::int64_t Whole __attribute__((vector_size(8 * LANES)));
inline unsigned bits_not_above(const Reals& a, const Reals& b) {
  return unsigned(a[0] <= b[0]) | unsigned(a[1] <= b[1]) << 1;
}
inline std::size_t keep(const Reals& d, const Reals& limit, const std::uint32_t* index, double* to,
                        std::uint32_t* from) {
  return keep_one_by_one<LANES>(d, limit, index, to, from);
}
inline void count_less(const Reals& a, const Reals& b, Whole& count) { count -= a < b; }
#include "geometry/points/kd_leaves.inc"
#undef LANES
}  // namespace baseline

#if PARTSCRIBE_VECTOR_VERSIONS
#pragma GCC push_options
#pragma GCC target("avx2,bmi")
namespace avx2 {
#define LANES 4
typedef double Reals __attribute__((vector_size(8 * LANES)));
typedef std::int64_t Whole __attribute__((vector_size(8 * LANES)));
inline unsigned bits_not_above(const Reals& a, const Reals& b) {
  return static_cast<unsigned>(_mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_LE_OQ)));
}
inline std::size_t keep(const Reals& d, const Reals& limit, const std::uint32_t* index, double* to,
                        std::uint32_t* from) {
  return keep_one_by_one<LANES>(d, limit, index, to, from);
}
inline void count_less(const Reals& a, const Reals& b, Whole& count) { count -= a < b; }
#include "geometry/points/kd_leaves.inc"
#undef LANES
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512vl,avx512dq,avx2,bmi,popcnt")
namespace avx512 {
#define LANES 8
typedef double Reals __attribute__((vector_size(8 * LANES)));
typedef std::int64_t Whole __attribute__((vector_size(8 * LANES)));
inline unsigned bits_not_above(const Reals& a, const Reals& b) { return _mm512_cmp_pd_mask(a, b, _CMP_LE_OQ); }
inline std::size_t keep(const Reals& d, const Reals& limit, const std::uint32_t* index, double* to,
                        std::uint32_t* from) {
  const __mmask8 kept = _mm512_cmp_pd_mask(d, limit, _CMP_LE_OQ);
  _mm512_storeu_pd(to, _mm512_maskz_compress_pd(kept, d));
  const __m256i all_indices = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(index));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(from), _mm256_maskz_compress_epi32(kept, all_indices));
  return static_cast<std::size_t>(__builtin_popcount(kept));
}
inline void count_less(const Reals& a, const Reals& b, Whole& count) {
  const __m512i before = reinterpret_cast<__m512i>(count);
  count = reinterpret_cast<Whole>(
      _mm512_mask_add_epi64(before, _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ), before, _mm512_set1_epi64(1)));
}
#include "geometry/points/kd_leaves.inc"
#undef LANES
}  // namespace avx512
#pragma GCC pop_options
#endif

struct Versions {
  decltype(&baseline::within) within;
  decltype(&baseline::rank) rank;
};

const Versions& versions(Instructions instructions) {
#define VERSION(set) \
  { set::within, set::rank }
  static constexpr Versions all[] = {PARTSCRIBE_EACH_VERSION(VERSION)};
#undef VERSION
  return all[static_cast<std::size_t>(instructions)];
}

}  // namespace

void points_within(const KdLeaf* leaves, const KdBoxes& boxes, const Vec3& query, double sq_limit, KdCandidates& found,
                   Instructions instructions) {
  versions(instructions).within(leaves, boxes, query, sq_limit, found);
}

bool rank_candidates(KdCandidates& candidates, Instructions instructions) {
  return versions(instructions).rank(candidates);
}

}  // namespace partscribe::geometry
