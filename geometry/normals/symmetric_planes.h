/// Normal equations of symmetric point to plane, eight pairs of oriented points at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "geometry/instructions.h"
#include "geometry/vec.h"

namespace partscribe::geometry {

/// A point with its unit normal: one line of the cache.
struct alignas(64) OrientedPoint {
  double x = 0, y = 0, z = 0, unused = 0, nx = 0, ny = 0, nz = 0, free = 0;
};

OrientedPoint oriented_point(const Vec3& point, const Vec3& normal);

/// How pairs count. Distances in mm; e is the distance along the mean of the two normals (Rusinkiewicz 2019).
struct SymmetricRule {
  Pose target_from_source;
  Vec3 origin = Vec3::Zero();  ///< rotations are about it, in the target's frame
  double size = 1;             ///< and are multiplied by this
  double reach = 1;            ///< weights exp(-d^2 / 2 reach^2 - e^2 / 2 wide^2), none beyond three times the reach
  double wide = 1;
  double least_cosine = 0.7071;  ///< of the angle between the two normals
};

/// Sums w r r', w e r and w over the rows r = [(c x n) / size, n], c the middle of a pair about the origin.
struct SymmetricSums {
  static constexpr std::size_t upper = 21;  ///< h by rows, from the diagonal on
  std::array<double, upper + 7> values{};   ///< h, six of g = -sum w e r, weights
};

/// Adds the pairs source[from[k]], target[to[k]] for k in [0, count). The same on every machine, in the last bit.
void add_symmetric(const OrientedPoint* source, const OrientedPoint* target, const std::uint32_t* from,
                   const std::uint32_t* to, std::size_t count, const SymmetricRule& rule, SymmetricSums& sums,
                   Instructions instructions = widest_instructions());

}  // namespace partscribe::geometry
