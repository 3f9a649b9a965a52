/// How noisy each point is, learned from the residuals of a fit: by view, by incidence, or by region.
#pragma once

#include <vector>

#include "fit/candidate.h"

namespace partscribe::fit {

/// What may make one point noisier than another. Columns are empty or one per point.
struct NoiseTraits {
  std::vector<int> group;  ///< view, or region where views are unknown; 0 .. group_count - 1
  int group_count = 1;
  std::vector<int> face;         ///< of the model; faces differ in roughness and in how a scanner saw them
  std::vector<double> cosine;    ///< of the incidence angle, 0..1
  std::vector<double> relative;  ///< standard deviation that came with the data, up to a common factor
  std::vector<char> told;  ///< 0 for points whose residuals are more than noise: they only get a sigma; empty: all
};

/// Standard deviation of every residual: overall scale x group x face x incidence, each factor shrunk towards 1 as far
/// as chance explains it (James & Stein 1961), so that evenly noisy data are left alone. Within a factor of 5 of the
/// overall scale, never below `least`.
std::vector<double> noise_of_points(const std::vector<double>& residuals, const NoiseTraits& traits, double least);

}  // namespace partscribe::fit
