/// Scans of single primitives with known truth, starts away from it, and what the best unbiased estimate could reach.
#pragma once

#include "core/random.h"
#include "geometry/surfaces/primitive_fit.h"

namespace partscribe::testing::primitives {

using namespace geometry;

inline constexpr PrimitiveKind kinds[] = {PrimitiveKind::plane,  PrimitiveKind::line,     PrimitiveKind::circle,
                                          PrimitiveKind::sphere, PrimitiveKind::cylinder, PrimitiveKind::cone,
                                          PrimitiveKind::torus};

/// Radius 20 (torus 30 and 10), cone of 0.4 rad, `offset` mm from the origin in a random direction.
Primitive example(PrimitiveKind kind, double offset, Random& random);

struct Scan {
  std::vector<Vec3> points;
  std::vector<Vec3> normals;  // exact; zero for lines and circles
};

/// Points over `arc` radians about the axis (planes: 60 mm square; of a sphere also `arc` from pole to pole; of a tube
/// wider than its ring the outside). Noise along the normal; of lines and circles in all three coordinates.
Scan scan(const Primitive& truth, std::size_t count, double arc, double sigma, Random& random);

/// The truth turned by `angle` about a random axis across its own, moved by `share` of its size and scaled by 1 +-
/// share.
Primitive start(const Primitive& truth, double angle, double share, Random& random);

/// The number that is judged: offset of planes and lines, half angle of cones, tube of tori, else the radius.
double number(const Primitive& primitive, const Primitive& truth);
double number_sigma(const PrimitiveFit& fit);

/// 1 sigma of the Cramer-Rao bound of that number, from derivatives of the distance by differences.
double bound(const Primitive& truth, const std::vector<Vec3>& exact_points, double sigma);

/// Root of the mean squared distance.
double rms(const Primitive& primitive, const std::vector<Vec3>& points);

}  // namespace partscribe::testing::primitives
