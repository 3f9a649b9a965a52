/// Which vector instructions the kernels of this folder are compiled for, and which of them this machine runs.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define PARTSCRIBE_VECTOR_VERSIONS 1
#else
#define PARTSCRIBE_VECTOR_VERSIONS 0
#endif

namespace partscribe {

/// avx2: with bmi; avx512: f, vl, dq, and popcnt. Kernels answer the same to the bit, whichever runs.
enum class Instructions { baseline, avx2, avx512 };

/// The widest that this machine runs.
Instructions widest_instructions();

}  // namespace partscribe
