#include "geometry/images/trimmed_window.h"

#include <algorithm>
#include <cmath>

namespace partscribe::geometry {
namespace {

// Small-sample factors, from 20,000 windows of Gaussian noise.
constexpr float plane_scale = 3.56F, quadric_scale = 3.77F;

/// All; halves with and without the line through the middle; quadrants; the inner 3x3.
constexpr int start_count = 22;

bool in_start(int start, int x, int y) {
  constexpr int direction[8][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}};
  if (start < 16) return direction[start / 2][0] * x + direction[start / 2][1] * y <= -(start % 2);
  if (start < 20) return (start % 2 ? -x : x) <= 0 && (start / 2 % 2 ? -y : y) <= 0;
  return start == 20 || (std::abs(x) <= 1 && std::abs(y) <= 1);
}

/// Weights of the `h` samples that lie best on a fit, and their sum of squares.
struct Best {
  Window weights{};
  float objective = 0;
};

Best best_of(const Window& heights, const Window& weights, const WindowFit& fit, std::size_t h) {
  std::array<std::pair<float, std::size_t>, 25> squares;
  std::size_t n = 0;
  for (std::size_t k = 0; k < 25; ++k) {
    if (weights[k] == 0) continue;
    const float r = heights[k] - fit.at(static_cast<int>(k % 5) - 2, static_cast<int>(k / 5) - 2);
    squares[n++] = {r * r, k};
  }
  std::nth_element(squares.begin(), squares.begin() + static_cast<std::ptrdiff_t>(h - 1),
                   squares.begin() + static_cast<std::ptrdiff_t>(n));
  Best best;
  for (std::size_t k = 0; k < h; ++k) best.objective += squares[k].first, best.weights[squares[k].second] = 1;
  return best;
}

}  // namespace

TrimmedWindow trimmed_window(const Window& heights, const Window& weights, bool quadric) {
  const auto fit_of = quadric ? quadric_fit : plane_fit;
  const std::size_t terms = quadric ? 6 : 3;
  TrimmedWindow result;
  const auto n = static_cast<std::size_t>(std::count(weights.begin(), weights.end(), 1.F));
  const std::size_t h = (n + terms + 1) / 2;
  if (n < terms + 2) return result.facet.variance = 1, result.middle = true, result;
  WindowFit best;
  float objective = -1;
  for (int start = 0; start < start_count; ++start) {
    Window subset = weights;
    for (int k = 0; k < 25; ++k)
      if (!in_start(start, k % 5 - 2, k / 5 - 2)) subset[static_cast<std::size_t>(k)] = 0;
    WindowFit fit = fit_of(heights, subset);
    for (int step = 0; step < 2 && fit.facet.model != RltsModel::raw; ++step)
      fit = fit_of(heights, best_of(heights, weights, fit, h).weights);
    if (fit.facet.model == RltsModel::raw) continue;
    const float found = best_of(heights, weights, fit, h).objective;
    if (objective < 0 || found < objective) objective = found, best = fit;
  }
  if (objective < 0) return result.facet.variance = 1, result.middle = true, result;
  // From the h smallest of n squares to a standard deviation: makes the mean 1 on Gaussian noise in full windows.
  const float scale = (quadric ? quadric_scale : plane_scale) * std::sqrt(objective / static_cast<float>(h));
  const float limit = 2.5F * 2.5F * 1.2F * std::max(1.F, scale * scale);
  Window accepted{};
  for (std::size_t k = 0; k < 25; ++k) {
    const float r = heights[k] - best.at(static_cast<int>(k % 5) - 2, static_cast<int>(k / 5) - 2);
    accepted[k] = weights[k] != 0 && r * r <= limit ? 1.F : 0.F;
  }
  result.facet = fit_of(heights, accepted).facet;
  result.middle = accepted[12] != 0;
  return result;
}

}  // namespace partscribe::geometry
