/// Gives a fitted candidate the numbers that will be printed, and makes it a model.
#pragma once

#include "fit/candidate.h"

namespace partscribe {

struct TidyOptions {
  double tolerance = 0.1;   ///< mm
  double size = 100;        ///< mm, of the part: a tilt that moves nothing this long by a tenth of the tolerance is none
  bool nominal = true;      ///< replace values by round ones where the data cannot tell them apart
};

/// Nominal candidates are multiples of 10, 5, 1, 0.5 and 0.1 mm and of 15, 5, 1 and 0.5 degrees, coarsest first. One is
/// kept if it lies within 2.5 sigma and a quarter of the tolerance, and chance would hit the grid so well in less than
/// one case of ten. All other values are rounded to a decimal step well below tolerance and sigma.
/// Normals of half-spaces become as square as the data allow.
void snap_parameters(Candidate& candidate, const TidyOptions& options);

/// The model of a candidate: placement as three lengths and three angles rounded below tolerance; turns that the shape
/// does not feel are left out.
Model model_of(const Candidate& candidate, const FitInput& input);

}  // namespace partscribe
