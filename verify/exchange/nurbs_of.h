/// OpenCASCADE's B-splines as ours.
#pragma once

#include "geometry/surfaces/nurbs.h"

class Geom_BSplineCurve;
class Geom_BSplineSurface;

namespace partscribe::verify {

/// Neither may be periodic. Weights are left out where all are alike.
NurbsCurve<3> nurbs_of(const Geom_BSplineCurve& curve);
NurbsSurface nurbs_of(const Geom_BSplineSurface& surface);

}  // namespace partscribe::verify
