/// Closed outlines in a plane as few B-spline curves: lines and cubics between corners.
#pragma once

#include <vector>

#include "geometry/surfaces/nurbs.h"

namespace partscribe::fit {

/// The closed outline through `places` (mm), each curve beginning where the one before ends: straight lines and cubics
/// within `tolerance` of it. Corners are where the outline turns by more than 40 degrees within some tolerances.
std::vector<NurbsCurve<2>> border_curves(const std::vector<Vec2>& places, double tolerance);

/// The same curve with all control points inside of a box. A polygon bulges beyond its curve: knots come where that
/// leads out of the box, until no place of the curve moves by more than `most`. Where the curve itself leaves the box,
/// it follows the border.
NurbsCurve<2> held_in(NurbsCurve<2> curve, const Vec2& low, const Vec2& high, double most);

}  // namespace partscribe::fit
