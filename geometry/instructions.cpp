#include "geometry/instructions.h"

namespace partscribe::geometry {
namespace {

Instructions supported() {
#if PARTSCRIBE_VECTOR_VERSIONS
  __builtin_cpu_init();
  const bool narrow = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi");
  const bool wide =
      __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq");
  if (narrow && wide && __builtin_cpu_supports("popcnt")) return Instructions::avx512;
  if (narrow) return Instructions::avx2;
#endif
  return Instructions::baseline;
}

}  // namespace

Instructions widest_instructions() {
  static const Instructions widest = supported();
  return widest;
}

}  // namespace partscribe::geometry
