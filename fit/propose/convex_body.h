/// The convex body with plane faces that explains a scan, hidden faces closed where the data end.
#pragma once

#include <vector>

#include "fit/candidate.h"
#include "geometry/mesh/convex.h"

namespace partscribe::fit {

/// A plane face of a convex body.
struct ConvexFace {
  Vec3 normal = Vec3::Zero();  ///< unit, outward
  double offset = 0;           ///< normal . p = offset, scan's frame
  std::size_t points = 0;      ///< that lie on it; 0: not scanned, the plane closes the body at the end of the data
};

/// mm; points within this of a plane may lie on it.
double reach_of(const FitInput& input);

/// Along the columns of `rotation`, around all points but the share `left_out` at either end of each axis.
Box3 box_along(const Mat3& rotation, const std::vector<Vec3>& points, double left_out);

/// Which plane of a convex body a point is nearest to, and how far outside (inside: negative) it is.
/// `second`: the same for the next nearest plane, which tells how near an edge is.
double convex_distance(const std::vector<ConvexFace>& faces, const Vec3& p, std::size_t* face = nullptr,
                       double* second = nullptr);

/// What the points cost, in nats, as the evidence for a candidate counts it (evidence.h).
double misfit_of(const std::vector<ConvexFace>& faces, const FitInput& input);

std::vector<Plane3> planes_only(const std::vector<ConvexFace>& faces);

/// Points on scanned faces: only they say where the data end.
std::vector<Vec3> points_on(const std::vector<ConvexFace>& faces, const FitInput& input, double reach);

/// The plane with outward normal `normal` at the end of the points.
ConvexFace closing_face(const std::vector<Vec3>& on, const Vec3& normal);

/// The scanned faces of the convex body that explains the points, largest first; empty if they are not those of one.
std::vector<ConvexFace> scanned_faces(const FitInput& input, Context& context);

/// The scanned faces and one more, of which the data show little: among the points far inside or outside of the closed
/// body, the plane that contains most of them and has hardly any points beyond it. Empty if it contains fewer points
/// than a face needs, or no more than chance explains.
std::vector<ConvexFace> with_a_face_more(std::vector<ConvexFace> scanned, const std::vector<ConvexFace>& closed,
                                         const FitInput& input, Context& context);

/// The faces with those that close the body where nothing was scanned; empty if the data do not determine them. They
/// are opposite or perpendicular to scanned ones if the data reach the edges that this gives; otherwise they lie where
/// they leave the scanned faces smallest.
std::vector<ConvexFace> closed_body(std::vector<ConvexFace> faces, const FitInput& input, Context& context);

}  // namespace partscribe::fit
