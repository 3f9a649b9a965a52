/// Where B-spline curves and surfaces meet.
///
/// Pieces without inner knots are halved as long as the boxes and slabs around their control points overlap, until
/// both of a pair are flat; Newton's steps lead from there onto both. Curves are followed from such a place to either
/// side, and every flat pair of pieces asks whether it has been passed: no part is left out that is longer than the
/// pieces that differ from flat ones by the tolerance. (Of the 1993 paper: "intersection curves of parametric surfaces
/// by subdivision techniques"; Lane and Riesenfeld, 1980, for the halving.)
#pragma once

#include <vector>

#include "geometry/surfaces/nurbs.h"

namespace partscribe::geometry {

/// A place on both; of a curve the parameter is x, and y is 0.
struct IntersectionPlace {
  Vec3 point = Vec3::Zero();
  Vec2 on_a = Vec2::Zero(), on_b = Vec2::Zero();
};

/// Places on both surfaces, to 1e-10 of their size, in order. Where the curve passes the end of a domain that another
/// end continues, the seam of a closed surface or its pole, the place is there twice with the parameters of both sides.
struct IntersectionCurve {
  std::vector<IntersectionPlace> places;
  bool closed = false;  ///< the last place is where the first is
};

struct SplineIntersection {
  std::vector<IntersectionCurve> curves;  ///< of two surfaces
  /// Of surfaces: where they touch, that is meet with parallel normals, and no curve is followed; one for each pair of
  /// flat pieces that does. Else: where they meet.
  std::vector<IntersectionPlace> places;
  bool complete = true;  ///< false: given up, as they lie upon one another over too many pieces
};

/// `tolerance`, mm, > 0: chords of curves are within it, and what is nearer to each other than twice as much is one.
SplineIntersection intersection_of(const NurbsSurface& a, const NurbsSurface& b, double tolerance);
SplineIntersection intersection_of(const NurbsCurve<3>& a, const NurbsSurface& b, double tolerance);
SplineIntersection intersection_of(const NurbsCurve<3>& a, const NurbsCurve<3>& b, double tolerance);

}  // namespace partscribe::geometry
