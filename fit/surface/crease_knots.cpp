#include "fit/surface/crease_knots.h"

#include <algorithm>

#include "fit/surface/net_equations.h"

namespace partscribe::fit {
namespace {

/// The points over part of one direction.
struct Strip {
  std::vector<Vec3> points;
  std::vector<Vec2> places;
  std::vector<double> weights;
};
Strip strip_of(const CreaseData& data, std::size_t axis, double low, double high) {
  Strip result;
  Vec3 mean = Vec3::Zero();
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    const double t = data.places[i][Eigen::Index(axis)];
    if (t < low || t > high) continue;
    result.points.push_back(data.points[i]), result.places.push_back(data.places[i]);
    if (!data.weights.empty()) result.weights.push_back(i < data.weights.size() ? data.weights[i] : 1);
    mean += data.points[i];
  }
  // Sums of squares lose fewer digits so.
  for (Vec3& p : result.points) p -= mean / double(result.points.size());
  return result;
}

}  // namespace

std::vector<std::size_t> narrow_spans(const std::vector<double>& breaks) {
  std::vector<std::size_t> result;
  const double mean = (breaks.back() - breaks.front()) / double(breaks.size() - 1);
  for (std::size_t i = 1; i + 2 < breaks.size(); ++i) {
    const double width = breaks[i + 1] - breaks[i];
    if (2.5 * width < mean && width <= breaks[i] - breaks[i - 1] && width <= breaks[i + 2] - breaks[i + 1])
      result.push_back(i);
  }
  return result;
}

std::optional<KnotVector> crease_knots(const CreaseData& data, const KnotVector& u, const KnotVector& v, bool along_u) {
  const KnotVector &knots = along_u ? u : v, &other = along_u ? v : u;
  const auto breaks = knots.breaks();
  const auto all = knots.multiplicities();
  const double mean = (breaks.back() - breaks.front()) / double(breaks.size() - 1);
  for (const std::size_t i : narrow_spans(breaks)) {
    // All knots of the short spans around it.
    std::size_t first = i, last = i + 1;
    while (first > 1 && breaks[first] - breaks[first - 1] < 0.5 * mean) --first;
    while (last + 2 < breaks.size() && breaks[last + 1] - breaks[last] < 0.5 * mean) ++last;
    std::vector<double> group;
    for (std::size_t k = first; k <= last; ++k) group.insert(group.end(), std::size_t(all[k].second), breaks[k]);
    if (group.size() < 3) continue;
    const double low = breaks[first - 1], high = breaks[last + 1];
    const Strip strip = strip_of(data, along_u ? 0 : 1, low, high);
    const auto gain = [&](const std::vector<double>& inner) {
      std::vector<double> lines = {low};
      lines.insert(lines.end(), inner.begin(), inner.end());
      lines.push_back(high);
      const KnotVector part = clamped(3, lines);
      NetEquations equations(along_u ? part : other, along_u ? other : part);
      equations.add(strip.points, strip.places, strip.weights);
      const auto net = equations.solve(equations.u(), equations.v(), data.fairness);
      if (!net) return -1e300;
      return equations.explained(*net) - data.noise * data.noise * double(part.count()) * double(other.count());
    };
    if (strip.points.size() < 2 * (group.size() + 4) * std::size_t(other.count())) continue;
    const double inset = 1e-3 * (high - low), least = gain(group);
    const double from = std::max(breaks[first], low + inset), to = std::min(breaks[last], high - inset);
    const auto one = [&](double at) { return gain({at, at, at}); };
    const double t = highest_place(one, from, to);
    if (one(t) < least) continue;
    KnotVector result = knots;
    std::erase_if(result.knots, [&](double k) { return k >= breaks[first] && k <= breaks[last]; });
    result.knots.insert(std::upper_bound(result.knots.begin(), result.knots.end(), t), 3, t);
    if (result != knots) return result;
  }
  return std::nullopt;
}

}  // namespace partscribe::fit
