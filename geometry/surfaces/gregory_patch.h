/// Gregory patches: four-sided surfaces whose tangents across each border are free of those across the others.
///
/// Chiyokura and Kimura, Design of solids with free-form surfaces, 1983, after Gregory. A bicubic patch has one inner
/// control point at each corner, which both borders there share; so tangent planes that are given along both can
/// contradict each other (the twists disagree). Here each inner point is two, mixed so that each border sees its own:
///   Q = (a across_v + b across_u) / (a + b),   a, b the parameters' distances from the corner along u and v.
#pragma once

#include <array>

#include "geometry/surfaces/nurbs.h"

namespace partscribe::geometry {

/// Over 0 .. 1 squared, mm.
struct GregoryPatch {
  /// Control points [i][j], i along u and j along v; the inner ones (i, j = 1, 2) are not read.
  std::array<std::array<Vec3, 4>, 4> points;
  /// Inner control points [i - 1][j - 1]: those that du sees along u = 0 and u = 1, and dv along v = 0 and v = 1.
  std::array<std::array<Vec3, 2>, 2> across_u, across_v;

  Vec3 at(double u, double v) const;
  /// First derivatives and unit normal along du x dv; in a corner its limit, where the second ones have none.
  struct Tangents {
    Vec3 p, du, dv;
    Vec3 normal() const;
  };
  Tangents tangents(double u, double v) const;
};

/// The same surface as a rational Bezier patch: numerator and denominator multiplied with the denominators of its
/// corners. Each corner whose twists disagree raises both degrees by one, so that they are 3 (polynomial) to 7.
///
/// The weight of such a corner would be zero, for there the second derivatives have no limit, and a rational surface
/// of positive weights would have them; IGES and NurbsSurface ask for positive ones. So it is `corner_weight` of the
/// largest: no place moves by more than some hundred times that share of the patch's size. In the corner itself du and
/// dv are zero up to rounding, for the control points beside it lie in it: take normals a little beside it.
NurbsSurface rational_bezier(const GregoryPatch& patch, double corner_weight = 1e-13);

}  // namespace partscribe::geometry
