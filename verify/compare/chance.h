/// Tail probabilities: how likely chance alone would have done it.
#pragma once

#include <cstddef>

namespace partscribe::verify {

/// P(N >= count) for N of a Poisson distribution.
double poisson_tail(std::size_t count, double mean);

/// P(N >= count) for N successes of `tries`, each of probability `p`.
double binomial_tail(std::size_t count, std::size_t tries, double p);

/// The z with P(|Z| > z) = `probability` for a standard normal Z.
double two_sided_quantile(double probability);

}  // namespace partscribe::verify
