/// Turns an evaluated sketch into the curves it means.
#pragma once

#include "geometry/surfaces/curve2.h"
#include "model/shapes.h"

namespace partscribe::model {

/// Ends nearer than this (mm) are one point.
inline constexpr double sketch_join = 1e-6;

/// All boundary curves, straight edges included, in order; names are the elements' roles, or "<loop> edge 3"
/// where there is none.
Outline2 outline_of(const EvaluatedSketch& sketch);

}  // namespace partscribe::model
