/// Planes through weighted neighbours and agreement with them, eight points at a time.
#pragma once

#include <cstddef>
#include <cstdint>

#include "geometry/instructions.h"

namespace partscribe::geometry {

/// A point as its neighbours see it: one line of the cache.
struct alignas(64) PlaneNode {
  double x = 0, y = 0, z = 0;
  double weight = 0;              ///< 0: nobody's neighbour
  double nx = 0, ny = 0, nz = 0;  ///< unit, of the round before
  double spread = 0;              ///< root mean square distance from its plane, in the round before
};

inline constexpr std::size_t plane_block = 8;

/// Eight nodes that follow one another, and their neighbours: the k-th of node i is links[8 k + i].
struct PlaneBlock {
  const PlaneNode* nodes;      ///< all
  std::size_t first;           ///< node of the block
  const std::uint32_t* links;  ///< where a node has fewer neighbours: a node of weight 0
  std::size_t rows;
};

struct PlaneWeights {
  const double* sq_reach;  ///< squared distance of the farthest neighbour of each of the eight
  double least_width;      ///< distance from the plane at which weights fall, where the spread is less
  bool first;              ///< there are no normals yet: only the distance counts
  bool two_sided;          ///< normals have no sign: the opposite one agrees
};

struct FoundPlanes {
  alignas(64) double x[plane_block], y[plane_block], z[plane_block];  ///< unit; NaN: the weights fix no plane
  alignas(64) double spread[plane_block];
  alignas(64) double moments[6][plane_block];  ///< covariances xx, yy, zz, xy, xz, yz
};

/// Direction of least weighted spread of the neighbours of each of eight nodes; weights fall with the distance, with
/// the fourth power of the cosine between normals, and with the distance from the plane of the round before. The same
/// on every machine, in the last bit.
void weighted_planes(const PlaneBlock& block, const PlaneWeights& weights, FoundPlanes& found,
                     Instructions instructions = widest_instructions());

struct SupportRule {
  double tolerance;   ///< mm from the plane
  double slope;       ///< and this much for each mm of distance
  bool either_plane;  ///< one of the two planes is enough
  double needed;      ///< counting ends when all eight have so many
};

/// How many of the neighbours in rows [1, rows) lie on one surface with each of eight nodes: the plane whose normal is
/// the mean of the two normals (exact on circles) or, across an edge, the neighbour's own.
void count_support(const PlaneBlock& block, const SupportRule& rule, double* support,
                   Instructions instructions = widest_instructions());

}  // namespace partscribe::geometry
