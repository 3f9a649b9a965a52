/// How noisy a range image is, from the differences between neighbours.
#pragma once

#include "geometry/images/padded_grid.h"
#include "geometry/images/range_heights.h"
#include "geometry/images/rlts_filter.h"

namespace partscribe::geometry {

/// Returns that are asked, about: their scale is known within a hundredth.
constexpr int noise_samples = 5000;

/// One level for the whole image, in mm, from about `samples` returns. Third differences, so that neither slope nor
/// curvature counts as noise.
RangeNoise even_noise(const RangeHeights& heights, int samples = noise_samples);

/// Level and growth with 1 / cos^2 of the incidence, from kept samples only.
RangeNoise sloped_noise(const RangeHeights& heights, const PaddedGrid<float>& kept, const PaddedGrid<float>& incidence);

}  // namespace partscribe::geometry
