/// Parts that are registered in tests and measurements, as rays meet them.
#pragma once

#include <vector>

#include "scan/simulate/simulate.h"

namespace partscribe::testing::registration {

using namespace scan;

/// Half spaces n.p <= d; a ray meets a convex part where it enters the last of them.
struct Side {
  Vec3 normal;
  double offset;
};
Surface convex(const std::vector<Side>& sides, double reach);

/// Of a block of twice these sizes about the origin.
std::vector<Side> block_sides(const Vec3& half);

/// Of two parts as one.
using FirstHit = decltype(Surface::first_hit);
FirstHit nearer_of(FirstHit a, FirstHit b);

/// A block with little beside its large faces: two edges and a corner are cut off.
Surface plain_block();

/// A block that nothing turns onto itself: every corner is cut differently.
Surface cut_block();

/// A block that half a turn about z lays onto itself, but for one corner that is cut so much less, mm.
Surface block_alike_from_two_sides(double difference);

/// A prism that a part of one turn about z lays onto itself, but for one of its upper corners that is cut so much less,
/// mm.
Surface prism_alike_from_sides(int sides, double difference);

/// A part that was moved.
Surface posed(const Surface& part, const Pose& pose);

struct Ball {
  Vec3 center;
  double radius;
};
Surface union_of(const std::vector<Ball>& parts, double reach);

/// Balls grown together: creases everywhere and no two alike.
Surface balls();

Surface ball(double radius);

/// Radius 10, height 30, about z.
Surface cylinder();

/// The same with balls grown into it.
Surface drum_with(const std::vector<Ball>& bumps, const Vec3& reach);

}  // namespace partscribe::testing::registration
