/// The bias of a fit due to noise along unknown viewing rays.
#pragma once

#include "fit/input/smoothing.h"
#include "fit/refine/all_points.h"
#include "model/distance/distance.h"

namespace partscribe::fit {

/// The bias that noise along the viewing rays causes: mm along the normal, one number per node. On a slanted surface
/// such noise also moves a point sideways, by sigma tan(incidence), and thereby off a curved surface by half the square
/// of that times its curvature. Zero where rays are known, because residuals then run along them (all_points.h), and
/// where the points lie all around. Otherwise the points show one side of the part only, and it is assumed to have been
/// seen along their mean normal.
Deviation slant_deviation(const Candidate& candidate, const AllPoints& all, const ModelDistance& distance, int threads);

}  // namespace partscribe::fit
