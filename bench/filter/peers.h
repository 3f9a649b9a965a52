/// What else is done to range images: plain forms of the usual filters.
#pragma once

#include <vector>

#include "bench/filter/scenes.h"

namespace partscribe::filter_bench {

/// Points in the sensor's frame, one per pixel; kept 0: discarded, or no return.
struct Filtered {
  std::vector<Vec3> points;
  std::vector<std::uint8_t> kept;
};

Filtered raw(const RangeImage& image);
/// Of the valid depths in 5x5.
Filtered median_filter(const RangeImage& image);
/// Gaussian over 5x5 (sigma 2 pixels) and over depth differences (three times the noise).
Filtered bilateral_filter(const RangeImage& image, double sigma);
/// Statistical outlier removal: mean distance to 20 neighbours beyond mean + 0.2 deviations of all.
Filtered statistical_removal(const RangeImage& image);
/// Statistical removal, then each point moved to a second-order moving least squares surface of radius 1.6 mm.
Filtered removal_and_mls(const RangeImage& image);

}  // namespace partscribe::filter_bench
