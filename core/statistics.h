/// Medians, quantiles, and means that outliers do not move.
#pragma once

#include <span>
#include <vector>

#include "core/layers.h"

namespace partscribe::core {

/// The middle value, of an even number of values the upper one of the two; 0 if there are none.
double median(std::vector<double> values);

/// As median, for loops that can spare the order of the values but not a copy.
double median_in_place(std::span<double> values);

/// The value at `share` of the way from the least to the largest in the sorted list, rounded down to a value that is
/// there; 0 if there are none.
double quantile(std::vector<double> values, double share);

struct RobustMean {
  double mean = 0;    ///< of the values within 2.5 spreads of the median
  double spread = 0;  ///< scaled median absolute deviation from the median: sigma, if they are Gaussian
};

/// All zero if there are no values.
RobustMean robust_mean(std::span<const double> values);

}  // namespace partscribe::core
