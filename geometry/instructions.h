/// Which vector instructions the kernels of this folder are compiled for, and which of them this machine runs.
#pragma once

#include "core/layers.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define PARTSCRIBE_VECTOR_VERSIONS 1
#else
#define PARTSCRIBE_VECTOR_VERSIONS 0
#endif

/// What `of` makes of the namespace of each version of a kernel, in the order of Instructions; without vector versions
/// the plain one.
#if PARTSCRIBE_VECTOR_VERSIONS
#define PARTSCRIBE_EACH_VERSION(of) of(baseline), of(avx2), of(avx512)
#else
#define PARTSCRIBE_EACH_VERSION(of) of(baseline), of(baseline), of(baseline)
#endif

#if defined(__clang__)
/// What GCC calls so: the lanes of one vector, or of two behind each other, by their numbers.
template <class V, class Numbers>
V __builtin_shuffle(const V& v, const Numbers& numbers) {
  V result;
  for (unsigned l = 0; l < sizeof v / sizeof v[0]; ++l) result[l] = v[numbers[l]];
  return result;
}
template <class V, class Numbers>
V __builtin_shuffle(const V& a, const V& b, const Numbers& numbers) {
  constexpr unsigned lanes = sizeof a / sizeof a[0];
  V result;
  for (unsigned l = 0; l < lanes; ++l) result[l] = unsigned(numbers[l]) < lanes ? a[numbers[l]] : b[numbers[l] - lanes];
  return result;
}
#endif

namespace partscribe::geometry {

/// avx2: with bmi; avx512: f, vl, dq, and popcnt. Kernels answer the same to the bit, whichever runs.
enum class Instructions { baseline, avx2, avx512 };

/// The widest that this machine runs.
Instructions widest_instructions();

}  // namespace partscribe::geometry
