#include "core/statistics.h"

#include <algorithm>
#include <cmath>

namespace partscribe::core {
namespace {

double at_rank(std::span<double> values, std::size_t rank) {
  if (values.empty()) return 0;
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace

double median_in_place(std::span<double> values) { return at_rank(values, values.size() / 2); }

double median(std::vector<double> values) { return median_in_place(values); }

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  return at_rank(values, static_cast<std::size_t>(share * static_cast<double>(values.size() - 1)));
}

RobustMean robust_mean(std::span<const double> values) {
  std::vector<double> work(values.begin(), values.end());
  const double middle = median_in_place(work);
  for (std::size_t i = 0; i < values.size(); ++i) work[i] = std::abs(values[i] - middle);
  const double spread = 1.4826 * median_in_place(work);
  double sum = 0, count = 0;
  for (const double v : values)
    if (std::abs(v - middle) <= 2.5 * spread + 1e-12) sum += v, ++count;
  return {count > 0 ? sum / count : 0, spread};
}

}  // namespace partscribe::core
