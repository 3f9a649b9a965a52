#include "fit/surface/line_basis.h"

#include <algorithm>
#include <cmath>

#include "core/ensure.h"
#include "geometry/surfaces/cubic_basis.h"

namespace partscribe::fit {

KnotVector without_one(const KnotVector& knots, double t) {
  KnotVector result = knots;
  result.knots.erase(std::find(result.knots.begin(), result.knots.end(), t));
  return result;
}

LineBasis::LineBasis(std::span<const double> lines, KnotVector knots, const LineBasis* near)
    : knots_(std::move(knots)), first_(lines.size()), value_(lines.size() * 4), factor_(count() * 4, 0.0) {
  // Knots `same` .. `other` - 1 are not those of `near`.
  std::size_t same = 0, other = knots_.knots.size();
  if (near && near->knots_.knots.size() == other) {
    const auto& before = near->knots_.knots;
    while (same < other && knots_.knots[same] == before[same]) ++same;
    while (other > same && knots_.knots[other - 1] == before[other - 1]) --other;
    first_ = near->first_, value_ = near->value_;
  }
  CubicBasis n(knots_);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    double* value = &value_[4 * i];
    if (same == 0 || (first_[i] + 7 > same && first_[i] < other)) {
      n.move_to(lines[i]);
      first_[i] = std::uint32_t(n.first);
      std::copy(n.value, n.value + 4, value);
    }
    double* row = &factor_[first_[i] * 4];
    row[3] += value[0] * value[0];
    row[6] += value[1] * value[0], row[7] += value[1] * value[1];
    row[9] += value[2] * value[0], row[10] += value[2] * value[1], row[11] += value[2] * value[2];
    row[12] += value[3] * value[0], row[13] += value[3] * value[1], row[14] += value[3] * value[2];
    row[15] += value[3] * value[3];
  }
  // Control values that no line tells are to lie in line with their neighbours.
  const std::size_t size = count();
  const double faint = 1e-10 * double(lines.size()) / double(size);
  for (std::size_t m = 1; m + 1 < size; ++m) {
    constexpr double w[3] = {1, -2, 1};
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t l = 0; l <= k; ++l) factor_[(m - 1 + k) * 4 + 3 - (k - l)] += faint * w[k] * w[l];
  }
  for (std::size_t i = 0; i < size; ++i) {
    double* row = &factor_[i * 4];
    for (std::size_t j = i < 3 ? 0 : i - 3; j <= i; ++j) {
      const double* other = &factor_[j * 4];
      double sum = row[3 - (i - j)];
      for (std::size_t k = i < 3 ? 0 : i - 3; k < j; ++k) sum -= row[3 - (i - k)] * other[3 - (j - k)];
      row[3 - (i - j)] = i == j ? 1 / std::sqrt(std::max(sum + 1e-3 * faint, 1e-300)) : sum * other[3];
    }
  }
}

std::vector<double> LineBasis::nearest(std::span<const double> values, std::size_t width) const {
  ensure(values.size() == lines() * width, "values for each line");
  std::vector<double> result(count() * width, 0.0);
  for (std::size_t i = 0; i < lines(); ++i) {
    const double *n = &value_[4 * i], *from = &values[i * width];
    for (std::size_t k = 0; k < 4; ++k) {
      double* to = &result[(first_[i] + k) * width];
      const double share = n[k];
      for (std::size_t w = 0; w < width; ++w) to[w] += share * from[w];
    }
  }
  solve(result.data(), width);
  return result;
}

void LineBasis::solve(double* right, std::size_t width) const {
  const std::size_t size = count();
  const auto subtract = [&](double share, const double* from, double* to) {
    for (std::size_t w = 0; w < width; ++w) to[w] -= share * from[w];
  };
  const auto scale = [&](double share, double* to) {
    for (std::size_t w = 0; w < width; ++w) to[w] *= share;
  };
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t k = i < 3 ? 0 : i - 3; k < i; ++k)
      subtract(factor_[i * 4 + 3 - (i - k)], right + k * width, right + i * width);
    scale(factor_[i * 4 + 3], right + i * width);
  }
  for (std::size_t i = size; i-- > 0;) {
    for (std::size_t k = i + 1; k < std::min(size, i + 4); ++k)
      subtract(factor_[k * 4 + 3 - (k - i)], right + k * width, right + i * width);
    scale(factor_[i * 4 + 3], right + i * width);
  }
}

LineBasis::Share LineBasis::share_of(double t) const {
  // What vanishes on all splines without this knot: orthogonal to the columns of the knot's insertion (Boehm).
  const KnotVector fewer = without_one(knots_, t);
  const auto span = std::size_t(fewer.span(t));
  double a[3];  // the shares of control values span - 2 .. span
  for (std::size_t k = 0; k < 3; ++k) {
    const double from = fewer.knots[span - 2 + k];
    a[k] = (t - from) / (fewer.knots[span + 1 + k] - from);
  }
  std::vector<double> x(count(), 0.0);
  const double gone[5] = {(1 - a[0]) * (1 - a[1]) / a[0], -(1 - a[1]) / a[0], 1, -a[1] / (1 - a[2]),
                          a[2] * a[1] / (1 - a[2])};
  for (std::size_t k = 0; k < 5; ++k) x[span - 3 + k] = gone[k];
  solve(x.data(), 1);
  double sq_size = 0;
  for (std::size_t k = 0; k < 5; ++k) sq_size += gone[k] * x[span - 3 + k];
  Share result;
  result.values.assign(lines(), 0.0);
  for (std::size_t i = 0; i < lines(); ++i) add_values(i, 1, x, std::span(result.values).subspan(i, 1));
  double most = 0;
  for (double& value : result.values) value /= std::sqrt(sq_size), most = std::max(most, std::abs(value));
  result.end = lines();
  const auto small = [&](std::size_t i) { return std::abs(result.values[i]) < 3e-3 * most; };
  while (result.end > 0 && small(result.end - 1)) --result.end;
  while (result.begin < result.end && small(result.begin)) ++result.begin;
  result.values.resize(result.end);
  result.values.erase(result.values.begin(), result.values.begin() + std::ptrdiff_t(result.begin));
  return result;
}

}  // namespace partscribe::fit
