/// Gives a fitted candidate the numbers that will be printed, and makes it a model.
#pragma once

#include "fit/candidate.h"

namespace partscribe::fit {

struct TidyOptions {
  double tolerance = 0.1;  ///< mm
  double size = 100;       ///< mm, of the part: a tilt that moves nothing this long by a tenth of the tolerance is none
  bool nominal = true;     ///< replace values by round ones where the data cannot tell them apart
};

/// Nominal sizes replace fitted ones where nominal_values() keeps them (fit/refine/nominal.h). All other values are
/// rounded to a decimal step well below tolerance and sigma. Normals of half-spaces become as square as the data allow.
void snap_parameters(Candidate& candidate, const TidyOptions& options);

/// The model of a candidate: placement as three lengths and three angles rounded below tolerance; turns that the shape
/// does not feel are left out.
Model model_of(const Candidate& candidate, const FitInput& input);

}  // namespace partscribe::fit
