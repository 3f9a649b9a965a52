#include "geometry/images/window_facet.h"

#include <algorithm>
#include <cmath>

#include "geometry/images/bent_surface.h"
#include "geometry/images/window_kernels.h"

namespace partscribe::geometry {
namespace {

constexpr float choice_of_side = 6.4F;  // 2 ln 24
constexpr float likely_bend = 6;        // instead of significant_bend: three terms as likely as not
constexpr float wild_sample = 9;        // chi^2 of a sample beyond three deviations, and what leaving it out costs

/// Reweighted: samples beyond three deviations are left out (`accepted` 0), at the price of as many deviations; at most
/// a fifth.
WindowFit trimmed(WindowFit (*least_squares)(const Window&, const Window&), const Window& heights,
                  const Window& weights, Window& accepted) {
  constexpr float limit = wild_sample;
  accepted = weights;
  WindowFit fit;
  int out = 0;
  for (int round = 0; round < 3; ++round) {
    fit = least_squares(heights, accepted);
    if (fit.facet.model == RltsModel::raw) return fit;
    int now = 0, all = 0;
    for (std::size_t k = 0; k < 25; ++k) {
      if (weights[k] == 0) continue;
      const float r = heights[k] - fit.at(static_cast<int>(k % 5) - 2, static_cast<int>(k / 5) - 2);
      accepted[k] = r * r <= limit ? 1.F : 0.F;
      now += r * r > limit, ++all;
    }
    if (now * 5 > all) {
      fit.facet.model = RltsModel::raw;
      return fit;
    }
    if (now == out) break;
    out = now;
  }
  fit.sse += limit * static_cast<float>(out);
  fit.good = fit.good && accepted[12] != 0;
  return fit;
}

/// Whether two planes explain the other samples so much better without the middle that it belongs to neither: a plane
/// through it and a few others steps across an edge.
bool wild_middle(const Window& heights, Window weights, float cost_with) {
  weights[12] = 0;
  Sides sides;
  split_window(heights, weights, sides);
  const float limit = *std::min_element(sides.cost.begin(), sides.cost.end()) + wild_sample;
  if (limit >= cost_with) return false;
  for (std::size_t j = 0; j < sides.cost.size(); ++j)
    if (sides.cost[j] < limit && sides.value[j] * sides.value[j] < wild_sample * (1 + sides.variance[j])) return false;
  return true;
}

/// Where the middle lies by all sides, each as likely as it explains the window.
void average(const Sides& sides, float least, WindowFacet& facet) {
  double weight = 0, value = 0, square = 0;
  for (std::size_t j = 0; j < sides.cost.size(); ++j) {
    if (sides.cost[j] > least + 14) continue;
    const double w = std::exp(-0.5 * static_cast<double>(sides.cost[j] - least)), v = sides.value[j];
    weight += w, value += w * v, square += w * (v * v + static_cast<double>(sides.variance[j]));
  }
  value /= weight, square /= weight;
  facet.value = static_cast<float>(value), facet.variance = static_cast<float>(square - value * value);
}

/// Of a few hundredths of all edges two planes say nothing (three faces meet, the edge is bent), and the sample alone
/// tells.
void doubt(WindowFacet& facet) {
  constexpr double outliers = 0.05;  // density of what they say then, in that of noise at its middle
  const double v = facet.value, left = std::max(1 - static_cast<double>(facet.variance), 0.01);
  const double wrong = outliers / (outliers + std::exp(-0.5 * v * v / left) / std::sqrt(left));
  facet.value = static_cast<float>((1 - wrong) * v);
  facet.variance =
      static_cast<float>((1 - wrong) * static_cast<double>(facet.variance) + wrong + wrong * (1 - wrong) * v * v);
}

/// What the samples say of a bend; those that are left out count as if they lay on the plane.
Bend bend_beside(const WindowFit& plane, const Window& heights, const Window& accepted) {
  Bend bend;
  for (int y = -2; y <= 2; ++y)
    for (int x = -2; x <= 2; ++x) {
      const auto k = static_cast<std::size_t>(5 * (y + 2) + x + 2);
      const float left = accepted[k] * (heights[k] - plane.at(x, y));
      bend.xx += left * static_cast<float>(x * x - 2), bend.yy += left * static_cast<float>(y * y - 2),
          bend.xy += left * static_cast<float>(x * y);
    }
  return {bend.xx / 70, bend.yy / 70, bend.xy / 100};
}

/// Fewer terms hold unless more are significant; but in a window that is not plain they are more likely than not, and
/// what they say of the middle makes it uncertain by how likely they are. `dearer`: how much more they cost; `facet`:
/// what holds.
void doubt_beside(float other_value, float dearer, WindowFacet& facet) {
  const float off = other_value - facet.value;
  facet.doubt += off * off / (1 + std::exp(0.5F * dearer));
}

}  // namespace

WindowFacet window_facet(const Window& heights, const Window& weights, bool firm) {
  WindowFacet best;
  best.variance = 1;
  float cost = 1e8F, count = 0;
  for (const float w : weights) count += w;
  const auto consider = [&](const WindowFit& fit, float price) {
    if (fit.facet.model == RltsModel::raw || fit.sse + price >= cost) return;
    cost = fit.sse + price;
    best = fit.good ? fit.facet : WindowFacet{0, 0, 0, 1, RltsModel::raw};
    best.cost = cost;
  };
  Window accepted;
  const WindowFit plane = trimmed(plane_fit, heights, weights, accepted);
  consider(plane, 0);
  if (best.model == RltsModel::plane) best.doubt += hidden_variance(bend_beside(plane, heights, accepted), likely_bend);
  if (cost < count + 10) return best;  // nothing dearer can be better
  Sides sides;
  split_window(heights, weights, sides);
  const auto side = static_cast<int>(std::min_element(sides.cost.begin(), sides.cost.end()) - sides.cost.begin());
  const auto s = static_cast<std::size_t>(side);
  const float split_cost = sides.cost[s] + significant_bend + choice_of_side;
  if (std::min(cost, split_cost) > significant_bend + 0.5F * count)
    consider(trimmed(quadric_fit, heights, weights, accepted), significant_bend);
  if (split_cost >= cost) {
    if (best.model != RltsModel::raw)
      doubt_beside(sides.value[s],
                   split_cost - cost - (best.model == RltsModel::plane ? significant_bend - likely_bend : 0), best);
    return best;
  }
  if (!firm && wild_middle(heights, weights, sides.cost[s])) return {0, 0, 0, 1, RltsModel::raw, split_cost};
  best = {sides.value[s], sides.slope_x[s], sides.slope_y[s], sides.variance[s], RltsModel::side, split_cost};
  average(sides, sides.cost[s], best);
  doubt(best);
  if (sides.near_count[s] < 9 || sides.near_sse[s] <= significant_bend + 0.5F * sides.near_count[s]) return best;
  Window near = weights;
  for (int k = 0; k < 25; ++k)
    if (!on_side(side, k % 5 - 2, k / 5 - 2)) near[static_cast<std::size_t>(k)] = 0;
  const WindowFit bent = quadric_fit(heights, near);
  if (!bent.good || bent.sse + significant_bend >= sides.near_sse[s]) return best;
  best = bent.facet, best.model = RltsModel::side;
  doubt(best);
  best.cost = split_cost - sides.near_sse[s] + bent.sse + significant_bend;
  return best;
}

}  // namespace partscribe::geometry
