/// How far a fitted surface and the true one are from each other, and how fair it is: the same code for all
/// contestants.
#pragma once

#include "fields.h"
#include "geometry/surfaces/nurbs.h"

namespace bench {

using partscribe::geometry::NurbsSurface;

struct Quality {
  double to_fit = 0;    ///< mm, the largest distance from the true surface to the fitted one
  double to_truth = 0;  ///< mm, the largest the other way, of what lies over the rectangle of the field
  double rms = 0;       ///< mm, from the true surface
  double bending = 0;   ///< integral of the squared principal curvatures over the area, over the rectangle; no unit
  double worst() const { return to_fit > to_truth ? to_fit : to_truth; }
};

/// From 321 x 241 places of both surfaces to their feet on the other.
Quality quality(const Field& field, const NurbsSurface& surface);

}  // namespace bench
