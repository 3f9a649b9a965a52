#include "fit/surface/grid_fit.h"

#include <algorithm>
#include <cmath>

#include "core/ensure.h"
#include "core/number.h"
#include "fit/surface/crease_knots.h"
#include "fit/surface/grid_net.h"

namespace partscribe::fit {
namespace {

// Steps of knots, over the gap to the next one: the first, how much the next is shorter, and none below that.
constexpr double first_step = 0.35, shorter = 3.5, least_step = 0.09;

class GridFitter {
 public:
  GridFitter(const SplineGrid& grid, const GridFitOptions& options, Context& context)
      : grid_(grid), options_(options), context_(context), net_(grid, options) {}

  std::optional<GridFit> fit() {
    net_.set({clamped(3, {grid_.u.front(), grid_.u.back()}), clamped(3, {grid_.v.front(), grid_.v.back()})});
    if (!refine()) return std::nullopt;
    take_out();
    net_.set(net_.knots());
    find_creases();
    // The samples tell nearly all; the points have the last word.
    for (int round = 0; round < 12; ++round) {
      if (net_.norm().worst > 1 && round < 6) settle_all();
      if (net_.norm().worst > 1 && !refine()) return std::nullopt;
      if (round < 6) simplify();
      const double worst = net_.look_at_all();
      if (worst <= options_.tolerance) return GridFit{net_.surface(), worst};
      net_.set(net_.knots());
    }
    return std::nullopt;
  }

 private:
  /// Knots are put in until the tolerance is kept.
  bool refine() {
    const double most = std::min(double(options_.most_controls), double(grid_.points.size()) / 3);
    for (int round = 0; net_.norm().worst > 1; ++round) {
      context_.say("free form: " + std::to_string(net_.knots(0).count()) + " x " +
                   std::to_string(net_.knots(1).count()) + " control points, off by " +
                   print_number(snapped(net_.norm().worst * options_.tolerance, options_.tolerance / 1000)) + " mm");
      find_creases();
      if (net_.norm().worst <= 1) break;
      auto more = refined();
      if (round == 40 || context_.cancelled || more == net_.knots()) return false;
      if (double(more[0].count()) * more[1].count() > most) return false;
      net_.set(std::move(more));
    }
    return true;
  }

  /// The knots with more of them in the middle of spans in which the tolerance is not kept, across the direction in
  /// which the distances vary.
  GridKnots refined() const {
    std::array<std::vector<double>, 2> breaks = {net_.knots(0).breaks(), net_.knots(1).breaks()};
    std::array<std::vector<char>, 2> split;
    std::array<std::vector<std::size_t>, 2> from;  // the first sample in each span
    for (std::size_t d : {0u, 1u}) {
      split[d].assign(breaks[d].size() - 1, 0);
      const GridSamples& at = net_.samples(d);
      std::size_t s = 0;
      for (std::size_t i = 0; i + 1 < breaks[d].size(); ++i) {
        from[d].push_back(s);
        while (s < at.count() && net_.lines(d)[at.begins[s] + at.window / 2] < breaks[d][i + 1]) ++s;
      }
      from[d].push_back(at.count());
    }
    const std::size_t row = net_.samples(0).count();
    const auto& off = net_.distances();
    std::vector<double> columns;
    for (std::size_t i = 0; i + 1 < breaks[0].size(); ++i)
      for (std::size_t j = 0; j + 1 < breaks[1].size(); ++j) {
        const std::size_t s0 = from[0][i], s1 = from[0][i + 1], t0 = from[1][j], t1 = from[1][j + 1];
        columns.assign(s1 - s0, 0.0);
        double worst = 0, mean = 0, by_v = 0, by_u = 0;
        for (std::size_t t = t0; t < t1; ++t) {
          double sum = 0;
          for (std::size_t s = s0; s < s1; ++s) {
            const double d = off[t * row + s];
            worst = std::max(worst, std::abs(d)), sum += d, columns[s - s0] += d;
          }
          mean += sum, by_v += sum * sum / double(s1 - s0);
        }
        if (worst <= 1) continue;
        for (const double sum : columns) by_u += sum * sum / double(t1 - t0);
        const double level = mean * mean / double((s1 - s0) * (t1 - t0));
        by_u -= level, by_v -= level;
        const double most = std::max(by_u, by_v), long_u = breaks[0][i + 1] - breaks[0][i],
                     long_v = breaks[1][j + 1] - breaks[1][j];
        const bool u = by_u >= 0.5 * most && long_u > 0.3 * long_v, v = by_v >= 0.5 * most && long_v > 0.3 * long_u;
        if (u || (!v && long_u > long_v)) split[0][i] = 1;
        if (v || (!u && long_u <= long_v)) split[1][j] = 1;
      }
    GridKnots result = net_.knots();
    for (std::size_t d : {0u, 1u})
      for (std::size_t i = 0; i < split[d].size(); ++i) {
        const double middle = 0.5 * (breaks[d][i] + breaks[d][i + 1]);
        if (split[d][i] && net_.held(d, breaks[d][i], middle) && net_.held(d, middle, breaks[d][i + 1]))
          result[d] = with_knot(result[d], middle);
      }
    return result;
  }

  /// Moves single knots of a direction between `low` and `high` once; true if one moved.
  bool sweep(std::size_t d, double low, double high, double by, bool until_kept) {
    bool better = false;
    for (const auto& [at, times] : net_.knots(d).multiplicities()) {
      if (times > 1 || at <= low || at >= high) continue;
      if (until_kept && net_.norm().worst <= 1) break;
      better = net_.move(d, at, by) || better;
    }
    return better;
  }

  void settle(std::size_t d, double low, double high) {
    for (double by = first_step; by > least_step && net_.norm().worst > 1;)
      if (!sweep(d, low, high, by, true)) by /= shorter;
  }

  /// All knots, until what is allowed is kept, or to leave room for fewer.
  void settle_all() {
    const bool until_kept = net_.norm().worst > 1;
    for (double by = first_step; by > least_step && !(until_kept && net_.norm().worst <= 1);) {
      const double before = net_.norm().sum;
      for (std::size_t d : {0u, 1u}) sweep(d, -1e300, 1e300, by, until_kept);
      if (!(net_.norm().sum < 0.8 * before)) by /= shorter;
    }
  }

  struct Knot {
    std::size_t direction;
    double at, size;
  };
  /// Those first that add least.
  std::vector<Knot> inner_knots() {
    std::vector<Knot> result;
    for (std::size_t d : {0u, 1u}) {
      const auto all = net_.knots(d).multiplicities();
      for (std::size_t i = 1; i + 1 < all.size(); ++i)
        result.push_back({d, all[i].first, net_.change_of(d, all[i].first).size});
    }
    std::stable_sort(result.begin(), result.end(), [](const Knot& a, const Knot& b) { return a.size < b.size; });
    return result;
  }

  /// By how much the sum of squares falls, mm^2, where these knots are put in, less what noise alone would make of it.
  double gain(std::size_t d, KnotVector knots, std::span<const double> added) {
    const double noise = options_.noise * options_.noise * double(net_.samples(1 - d).count()) *
                         double(net_.knots(1 - d).count()) / double(net_.lines(1 - d).size());
    double result = 0;
    for (const double t : added) {
      knots = with_knot(knots, t);
      result += net_.change_of(d, knots, t).energy - noise;
    }
    return result;
  }

  /// One multiple knot in place of those that crowd around a crease: of the multiplicity and in the place that leaves
  /// no more than they do.
  void find_creases() {
    for (std::size_t d : {0u, 1u}) {
      const auto breaks = net_.knots(d).breaks();
      for (const std::size_t i : narrow_spans(breaks))
        if (auto knots = net_.knots(); one_for_many(d, breaks[i], breaks[i + 1], knots[d])) {
          net_.set(std::move(knots));
          break;  // the spans are others now
        }
    }
  }

  /// The knots from `low` to `high`, and as many beside them as can go, for one multiple knot.
  bool one_for_many(std::size_t d, double low, double high, KnotVector& knots) {
    KnotVector rest = knots, best;
    std::vector<double> group;
    const auto take = [&](double t) { group.push_back(t), rest = without_one(rest, t); };
    for (const double t : {low, high})
      while (std::binary_search(rest.knots.begin(), rest.knots.end(), t)) take(t);
    for (bool more = true; more && group.size() <= 12;) {
      const double least = gain(d, rest, group);
      const auto [from, to] = std::minmax_element(group.begin(), group.end());
      bool enough = false;
      // Three first; two where the third adds nothing.
      double least_of_one = least;
      for (std::size_t times = 3; times >= 2 && group.size() >= 3; --times) {
        const auto one = [&](double at) { return gain(d, rest, std::vector<double>(times, at)); };
        const double t = highest_place(one, *from, *to, 1e-4);
        const auto next = std::lower_bound(rest.knots.begin(), rest.knots.end(), t);
        if (!(*(next - 1) < t && t < *next && net_.held(d, *(next - 1), t) && net_.held(d, t, *next))) break;
        const double found = one(t);
        if (found < least_of_one) break;
        least_of_one = std::max(least, found - 1e-6 * found);
        enough = true, best = rest;
        for (std::size_t i = 0; i < times; ++i) best = with_knot(best, t);
      }
      // The nearer one of those beside.
      const auto after = std::upper_bound(rest.knots.begin(), rest.knots.end(), low);
      const double before = *(after - 1), next = *after;
      const bool first = before > rest.low(), last = next < rest.high();
      more = (first || last) && (enough || group.size() < 4);
      if (more) take(first && (!last || low - before < next - high) ? before : next);
    }
    if (best.knots.empty()) return false;
    knots = std::move(best);
    return true;
  }

  /// Fewer knots as long as what is allowed is kept.
  void simplify() {
    for (double many = 1e300; net_.controls() < many && !context_.cancelled;) {
      while (replace()) take_out();
      many = net_.controls();
      settle_all();
      take_out();
    }
    net_.look();
  }

  /// Takes out what can go alone.
  void take_out() {
    for (bool any = true; any && !context_.cancelled;) {
      any = false;
      int needed = 0;
      for (const Knot& knot : inner_knots()) {
        if (needed == 6) break;
        if (net_.take_out(knot.direction, knot.at, 1))
          any = true;
        else
          ++needed;
      }
    }
  }

  /// Takes one out and moves those beside it.
  bool replace() {
    const GridNet::State before = net_.state();
    int tried = 0;
    for (const Knot& knot : inner_knots()) {
      if (++tried > 4) break;
      const std::size_t d = knot.direction;
      if (!net_.take_out(d, knot.at, 3)) continue;
      const auto breaks = net_.knots(d).breaks();
      const auto next = std::upper_bound(breaks.begin(), breaks.end(), knot.at) - breaks.begin();
      const auto low = std::max<std::ptrdiff_t>(next - 4, 0), high = std::min(next + 3, std::ssize(breaks) - 1);
      settle(d, breaks[std::size_t(low)], breaks[std::size_t(high)]);
      if (net_.norm().worst <= 1) return true;
      net_.restore(before);
    }
    return false;
  }

  const SplineGrid& grid_;
  const GridFitOptions& options_;
  Context& context_;
  GridNet net_;
};

}  // namespace

std::optional<GridFit> fit_grid(const SplineGrid& grid, const GridFitOptions& options, Context& context) {
  ensure(grid.points.size() == grid.u.size() * grid.v.size(), "a point for each pair of parameters");
  if (grid.u.size() < 4 || grid.v.size() < 4) return std::nullopt;
  return GridFitter(grid, options, context).fit();
}

}  // namespace partscribe::fit
