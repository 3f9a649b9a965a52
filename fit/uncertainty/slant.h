/// The bias of a fit due to noise along unknown viewing rays.
#pragma once

#include "fit/input/smoothing.h"
#include "fit/refine/all_points.h"
#include "model/distance/distance.h"

namespace partscribe::fit {

/// A range sensor's noise moves a point of a slanted surface sideways as well, by sigma tan(incidence), and off a
/// curved one by half the square of that times its curvature. Where rays are known the residuals run along them
/// (all_points.h). Where they are not, and the points show one side of the part only, the part was seen about along
/// their mean normal: the deviation that this would mean, mm along the normal, one number per node. All zero where the
/// points lie all around.
Deviation slant_deviation(const Candidate& candidate, const AllPoints& all, const ModelDistance& distance, int threads);

}  // namespace partscribe::fit
