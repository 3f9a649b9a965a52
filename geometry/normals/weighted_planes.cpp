#include "geometry/normals/weighted_planes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#if PARTSCRIBE_VECTOR_VERSIONS
#include <immintrin.h>
#endif

// Vectors stay inside this file; how they would be passed between files does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"
#pragma GCC diagnostic ignored "-Wuninitialized"  // what the compiler's own header leaves open on purpose

namespace partscribe::geometry {
namespace {

namespace baseline {
#define LANES 2
typedef double Pair __attribute__((vector_size(16)));
inline bool none_below(const Pair& a, const Pair& b) { return a[0] >= b[0] && a[1] >= b[1]; }
#include "geometry/normals/weighted_planes.inc"
#undef LANES
}  // namespace baseline

#if PARTSCRIBE_VECTOR_VERSIONS
#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
#define LANES 4
inline bool none_below(const __m256d& a, const __m256d& b) {
  return _mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_LT_OQ)) == 0;
}
#include "geometry/normals/weighted_planes.inc"
#undef LANES
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512vl,avx512dq,avx2")
namespace avx512 {
#define LANES 8
inline bool none_below(const __m512d& a, const __m512d& b) { return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ) == 0; }
#include "geometry/normals/weighted_planes.inc"
#undef LANES
}  // namespace avx512
#pragma GCC pop_options
#endif

struct Versions {
  decltype(&baseline::weighted) weighted;
  decltype(&baseline::support) support;
};

const Versions& versions(Instructions instructions) {
#define VERSION(set) \
  { set::weighted, set::support }
  static constexpr Versions all[] = {PARTSCRIBE_EACH_VERSION(VERSION)};
#undef VERSION
  return all[static_cast<std::size_t>(instructions)];
}

}  // namespace

void weighted_planes(const PlaneBlock& block, const PlaneWeights& weights, FoundPlanes& found,
                     Instructions instructions) {
  versions(instructions).weighted(block, weights, found);
}

void count_support(const PlaneBlock& block, const SupportRule& rule, double* support, Instructions instructions) {
  versions(instructions).support(block, rule, support);
}

}  // namespace partscribe::geometry
