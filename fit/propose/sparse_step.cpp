#include "fit/propose/sparse_step.h"

#include <algorithm>
#include <cmath>

#include "core/statistics.h"

namespace partscribe::fit {

std::optional<SparseStep> step_beyond(const std::vector<Vec2>& places, double from, double sign, double noise,
                                      std::size_t least) {
  constexpr double half_band = 2.5;        // sigmas
  constexpr double surely = 7;             // nats; odds of a thousand
  constexpr std::size_t most_tried = 400;  // radii
  const double band = half_band * noise;
  const auto radius = [](const Vec2& p) { return p.x(); };
  std::vector<Vec2> beyond;  // radius, and how far beyond
  for (const Vec2& p : places)
    if (const double t = sign * (p.y() - from); t > band) beyond.emplace_back(p.x(), t);
  if (beyond.size() < least) return std::nullopt;
  std::sort(beyond.begin(), beyond.end(),
            [](const Vec2& a, const Vec2& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  const double n = double(beyond.size()), widest = beyond.back().x();
  const double farthest = std::ranges::max_element(beyond, {}, [](const Vec2& p) { return p.y(); })->y();
  const double tests = std::log(n * n);  // a radius, and where the wall ends
  const std::size_t step = (beyond.size() + most_tried - 1) / most_tried;
  SparseStep best;
  double best_nats = surely;
  for (std::size_t k = 0; k < beyond.size(); k += step) {
    const double r = beyond[k].x(), low = r - band, high = std::min(r + band, widest);
    if (!(low > 0)) continue;  // about the axis there is no room for a wall
    std::vector<double> reached, radii;
    const auto first = std::ranges::upper_bound(beyond, low, {}, radius),
               last = std::ranges::lower_bound(beyond, high, {}, radius);
    for (auto p = first; p < last; ++p) reached.push_back(p->y()), radii.push_back(p->x());
    if (reached.size() < least) continue;
    std::sort(reached.begin(), reached.end());
    const double ring = (high * high - low * low) / (widest * widest);  // share of the room
    for (std::size_t i = least - 1; i < reached.size(); ++i) {
      const double chance = ring * reached[i] / farthest, share = std::min(double(i + 1) / n, 1 - 1e-9);
      if (!(share > chance)) continue;
      const double nats =
          n * (share * std::log(share / chance) + (1 - share) * std::log((1 - share) / (1 - chance))) - tests;
      if (nats > best_nats) best_nats = nats, best = {median(radii), from + sign * reached[i], i + 1};
    }
  }
  if (best.points == 0) return std::nullopt;
  return best;
}

}  // namespace partscribe::fit
