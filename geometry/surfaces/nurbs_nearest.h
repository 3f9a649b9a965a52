/// The nearest place of a whole B-spline curve or surface to a point, wherever it is.
#pragma once

#include "geometry/surfaces/nurbs.h"

namespace partscribe::geometry {

/// The foot that Newton's steps reach from a start near it; at an end of the domain if they lead out of it. v stays 0.
SplineFoot foot_near(const NurbsCurve<3>& curve, const Vec3& p, double u);

/// No place is nearer than the one returned by more than `tolerance`, mm, > 0. Where several are equally near it is one
/// of them, always the same one. Pieces are halved until the control values of their squared distance, a polynomial by
/// its weight, say that they are too far; Newton's steps find the feet in the others.
SplineFoot nearest_on(const NurbsCurve<3>& curve, const Vec3& p, double tolerance = 1e-9);
SplineFoot nearest_on(const NurbsSurface& surface, const Vec3& p, double tolerance = 1e-9);

}  // namespace partscribe::geometry
