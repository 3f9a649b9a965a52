#include "geometry/weighted_planes.h"

#include <cmath>
#include <cstring>
#include <limits>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define PARTSCRIBE_VECTOR_VERSIONS 1
#include <immintrin.h>
#else
#define PARTSCRIBE_VECTOR_VERSIONS 0
#endif

// Vectors stay inside this file; how they would be passed between files does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"
#pragma GCC diagnostic ignored "-Wuninitialized"  // what the compiler's own header leaves open on purpose

namespace partscribe {
namespace {

namespace baseline {
#define LANES 2
typedef double Pair __attribute__((vector_size(16)));
inline Pair root(const Pair& x) { return Pair{std::sqrt(x[0]), std::sqrt(x[1])}; }
inline bool none_below(const Pair& a, const Pair& b) { return a[0] >= b[0] && a[1] >= b[1]; }
#include "geometry/weighted_planes.inc"
#undef LANES
}  // namespace baseline

#if PARTSCRIBE_VECTOR_VERSIONS
#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
#define LANES 4
inline __m256d root(const __m256d& x) { return _mm256_sqrt_pd(x); }
inline bool none_below(const __m256d& a, const __m256d& b) { return _mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_LT_OQ)) == 0; }
#include "geometry/weighted_planes.inc"
#undef LANES
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512vl,avx512dq,avx2")
namespace avx512 {
#define LANES 8
inline __m512d root(const __m512d& x) { return _mm512_sqrt_pd(x); }
inline __m512d halves(const double* low, const double* high) {
  return _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_loadu_pd(low)), _mm256_loadu_pd(high), 1);
}
inline bool none_below(const __m512d& a, const __m512d& b) { return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ) == 0; }
#include "geometry/weighted_planes.inc"
#undef LANES
}  // namespace avx512
#pragma GCC pop_options
#endif

/// The widest version that this machine runs.
struct Versions {
  decltype(&baseline::weighted) weighted = baseline::weighted;
  decltype(&baseline::support) support = baseline::support;
  Versions() {
#if PARTSCRIBE_VECTOR_VERSIONS
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq"))
      weighted = avx512::weighted, support = avx512::support;
    else if (__builtin_cpu_supports("avx2"))
      weighted = avx2::weighted, support = avx2::support;
#endif
  }
};

const Versions& versions() {
  static const Versions chosen;
  return chosen;
}

}  // namespace

void weighted_planes(const PlaneBlock& block, const PlaneWeights& weights, FoundPlanes& found) {
  versions().weighted(block, weights, found);
}

void count_support(const PlaneBlock& block, const SupportRule& rule, double* support) {
  versions().support(block, rule, support);
}

}  // namespace partscribe
