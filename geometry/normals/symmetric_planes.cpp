#include "geometry/normals/symmetric_planes.h"

#include <cmath>
#include <cstring>

#if PARTSCRIBE_VECTOR_VERSIONS
#include <immintrin.h>
#endif

// Vectors stay inside this file; how they would be passed between files does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"
#pragma GCC diagnostic ignored "-Wuninitialized"  // what the compiler's own header leaves open on purpose

namespace partscribe::geometry {
namespace {

constexpr std::size_t symmetric_block = 8;

namespace baseline {
#define LANES 2
#include "geometry/normals/symmetric_planes.inc"
#undef LANES
}  // namespace baseline

#if PARTSCRIBE_VECTOR_VERSIONS
#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
#define LANES 4
#include "geometry/normals/symmetric_planes.inc"
#undef LANES
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512vl,avx512dq,avx2")
namespace avx512 {
#define LANES 8
#include "geometry/normals/symmetric_planes.inc"
#undef LANES
}  // namespace avx512
#pragma GCC pop_options
#endif

decltype(&baseline::pairs) version(Instructions instructions) {
#define VERSION(set) set::pairs
  static constexpr decltype(&baseline::pairs) all[] = {PARTSCRIBE_EACH_VERSION(VERSION)};
#undef VERSION
  return all[static_cast<std::size_t>(instructions)];
}

}  // namespace

OrientedPoint oriented_point(const Vec3& point, const Vec3& normal) {
  return {point.x(), point.y(), point.z(), 0, normal.x(), normal.y(), normal.z(), 0};
}

void add_symmetric(const OrientedPoint* source, const OrientedPoint* target, const std::uint32_t* from,
                   const std::uint32_t* to, std::size_t count, const SymmetricRule& rule, SymmetricSums& sums,
                   Instructions instructions) {
  alignas(64) double lanes[SymmetricSums::upper + 7][symmetric_block];
  version(instructions)(source, target, from, to, count, rule, lanes);
  for (std::size_t v = 0; v < sums.values.size(); ++v) {
    const double* l = lanes[v];
    sums.values[v] += ((l[0] + l[1]) + (l[2] + l[3])) + ((l[4] + l[5]) + (l[6] + l[7]));
  }
}

}  // namespace partscribe::geometry
