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

/// What an outline encloses, in the plane z = 0.
Box3 flat_box(const Outline2& outline);

/// For each of the outline's loops those that it lies in, in rising order, by one of its points: for loops that do not
/// cross.
std::vector<std::vector<std::size_t>> loops_around(const Outline2& outline, std::size_t loops);

}  // namespace partscribe::model
