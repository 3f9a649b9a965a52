#include "verify/compare/chance.h"

#include <algorithm>
#include <cmath>

namespace partscribe::verify {
namespace {

/// Sum of terms that start at `first` and are multiplied by ratio(i) from one to the next, until they fade.
template <class Ratio>
double sum_of(double first, std::size_t from, std::size_t to, Ratio ratio) {
  double term = first, sum = 0;
  for (std::size_t i = from; i <= to; ++i) {
    sum += term;
    const double factor = ratio(i);
    if (factor < 1 && term * factor < 1e-17 * sum) break;
    term *= factor;
  }
  return std::min(sum, 1.0);
}

/// std::lgamma leaves the sign in a variable that all threads share.
double log_gamma(double x) {
  int sign = 0;
  return lgamma_r(x, &sign);
}

}  // namespace

double poisson_tail(std::size_t count, double mean) {
  if (count == 0) return 1;
  if (!(mean > 0)) return 0;
  const auto k = static_cast<double>(count);
  if (k <= mean) return 1;  // not worth telling apart: no alarm is below its own mean
  const double first = std::exp(k * std::log(mean) - mean - log_gamma(k + 1));
  return sum_of(first, count, count + 100000, [&](std::size_t i) { return mean / static_cast<double>(i + 1); });
}

double binomial_tail(std::size_t count, std::size_t tries, double p) {
  if (count == 0) return 1;
  if (count > tries || !(p > 0)) return 0;
  const auto k = static_cast<double>(count), n = static_cast<double>(tries);
  if (p >= 1 || k <= n * p) return 1;
  const double first =
      std::exp(log_gamma(n + 1) - log_gamma(k + 1) - log_gamma(n - k + 1) + k * std::log(p) + (n - k) * std::log1p(-p));
  return sum_of(first, count, tries, [&](std::size_t i) {
    return (n - static_cast<double>(i)) / (static_cast<double>(i) + 1) * p / (1 - p);
  });
}

double two_sided_quantile(double probability) {
  double low = 0, high = 40;
  for (int step = 0; step < 100; ++step) {
    const double middle = 0.5 * (low + high);
    (std::erfc(middle / std::sqrt(2.0)) > probability ? low : high) = middle;
  }
  return low;
}

}  // namespace partscribe::verify
