/// Correlation of a scan's noise: how many points are worth one independent one.
#pragma once

#include <vector>

#include "geometry/vec.h"

namespace partscribe::fit {

struct Correlation {
  double points_per_independent = 1;  ///< 1 for white noise
  /// mm^2, variance per axis of the filter that would correlate white noise so; 0: too little for one
  double smoothing = 0;
};

/// Autocorrelation of `residuals` (any common scale) against the distance between points of the same `group` (views
/// have separate noise), up to some six pixels. What has not decayed by then is no noise but a systematic deviation,
/// and is left out. Lags are summed up to the first that chance could explain, so that white noise gives 1. `places`
/// are the points without their noise, except for what is common to all: measured points with similar errors lie closer
/// together than others, which would look like correlation.
Correlation correlation_of(const std::vector<Vec3>& places, const std::vector<double>& residuals,
                           const std::vector<int>& group, int group_count, int threads);

}  // namespace partscribe::fit
