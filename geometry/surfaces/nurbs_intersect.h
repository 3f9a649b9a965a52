/// Where B-spline curves and surfaces meet.
///
/// Both are cut along their creases; their pieces without inner knots are halved as long as the boxes and slabs around
/// the control points of two overlap, until these are flat within the tolerance and their normals differ, or flat
/// within a thousandth of it. Newton's steps lead from there onto both. Curves are followed from such a place to either
/// side, and every flat pair asks whether it has been passed, so that closed curves and all branches are found: left
/// out are only places in which one pokes through the other by less than about a tenth of the tolerance. (The 1993
/// paper, section 3.2: "intersection curves of parametric surfaces by subdivision techniques"; Lane and Riesenfeld,
/// 1980.)
#pragma once

#include <vector>

#include "geometry/surfaces/nurbs.h"

namespace partscribe::geometry {

/// A place on both; of a curve the parameter is x, and y is 0.
struct IntersectionPlace {
  Vec3 point = Vec3::Zero();
  Vec2 on_a = Vec2::Zero(), on_b = Vec2::Zero();
};

/// Places on both surfaces, to 1e-10 of their size, in order. Where the curve passes a crease, or the end of a domain
/// that another end continues, as the seam of a closed surface does, or its pole, the place is there twice, with the
/// parameters of both sides.
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

/// `tolerance`, mm, > 0: chords are within it of the curves, and what runs the same way nearer to another than twice as
/// much is one with it.
SplineIntersection intersection_of(const NurbsSurface& a, const NurbsSurface& b, double tolerance);
SplineIntersection intersection_of(const NurbsCurve<3>& a, const NurbsSurface& b, double tolerance);
SplineIntersection intersection_of(const NurbsCurve<3>& a, const NurbsCurve<3>& b, double tolerance);

}  // namespace partscribe::geometry
