/// What else is done to range images: filters of the Point Cloud Library.
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
/// A filter of another program, told the noise at normal incidence, mm.
struct Peer {
  const char* name;
  Filtered (*run)(const RangeImage& image, double sigma);
};

/// Empty where PCL was not found when the benchmark was built.
std::vector<Peer> pcl_filters();

}  // namespace partscribe::filter_bench
