#include "fit/surface/knot_choice.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace partscribe::fit {
namespace {

constexpr int lines = 17;  // across, along which derivatives are looked at
using Across = std::array<Vec3, lines>;

/// How far the third derivative jumps at each knot inside, mm / mm^3, on lines across.
std::vector<Across> jumps(const NurbsSurface& s, bool along_u) {
  const auto used = (along_u ? s.u : s.v).breaks();
  const KnotVector& other = along_u ? s.v : s.u;
  std::vector<Across> result;
  Across before;
  for (std::size_t i = 0; i + 1 < used.size(); ++i) {
    Across third;
    const double h = (used[i + 1] - used[i]) / 4;
    for (std::size_t l = 0; l < lines; ++l) {
      const double across = other.low() + (other.high() - other.low()) * double(l) / (lines - 1);
      const auto second = [&](double t) {
        return along_u ? s.derivatives(t, across).duu : s.derivatives(across, t).dvv;
      };
      third[l] = (second(used[i + 1] - h) - second(used[i] + h)) / (2 * h);
    }
    if (i > 0) {
      auto& jump = result.emplace_back();
      for (std::size_t l = 0; l < lines; ++l) jump[l] = third[l] - before[l];
    }
    before = third;
  }
  return result;
}

/// What a surface leaves, over what is allowed: the largest, and a norm that all large ones count in.
struct Left {
  double worst = 0, norm = 0;
};
Left left_by(const NetEquations& equations, const NurbsSurface& surface, double averaged, double allowed) {
  const auto left = equations.left(surface);
  Left result;
  for (std::size_t i = 0; i < left.mean.size(); ++i) {
    if (left.points[i] < averaged) continue;
    const double d = std::abs(left.mean[i]) / allowed, d2 = d * d, d4 = d2 * d2;
    result.worst = std::max(result.worst, d);
    result.norm += d4 * d4;
  }
  return result;
}

/// Which of the fine breaks are knots, ascending, the ends left out.
using Chosen = std::array<std::vector<int>, 2>;

class Choice {
 public:
  Choice(const NetEquations& equations, const NurbsSurface& start, const KnotChoiceOptions& options)
      : equations_(equations),
        options_(options),
        breaks_{equations.u().breaks(), equations.v().breaks()},
        surface_(start) {
    for (std::size_t k : {0u, 1u}) {
      const KnotVector& used = k == 0 ? start.u : start.v;
      for (std::size_t i = 4; i + 4 < used.knots.size(); ++i) {
        const auto at = std::lower_bound(breaks_[k].begin(), breaks_[k].end(), used.knots[i]);
        best_[k].push_back(int(at - breaks_[k].begin()));
      }
    }
  }

  std::pair<KnotVector, KnotVector> fewest() {
    deal_out();
    while (take_out()) {
    }
    return {knots(best_, 0), knots(best_, 1)};
  }

 private:
  KnotVector knots(const Chosen& chosen, std::size_t k) const {
    std::vector<double> result = {breaks_[k].front()};
    for (const int i : chosen[k]) result.push_back(breaks_[k][std::size_t(i)]);
    result.push_back(breaks_[k].back());
    return clamped(3, result);
  }

  static double controls(const Chosen& chosen) {
    return (double(chosen[0].size()) + 4) * (double(chosen[1].size()) + 4);
  }

  Left left(const Chosen& chosen, std::optional<NurbsSurface>* found = nullptr) const {
    ++asked_;
    auto surface = equations_.solve(knots(chosen, 0), knots(chosen, 1), options_.fairness);
    if (!surface) return {1e300, 1e300};
    const Left result = left_by(equations_, *surface, options_.averaged, options_.allowed);
    if (found) *found = std::move(surface);
    return result;
  }

  /// Takes a choice over if it leaves no more than allowed.
  bool accept(const Chosen& chosen) {
    std::optional<NurbsSurface> surface;
    if (left(chosen, &surface).worst > 1) return false;
    best_ = chosen, surface_ = std::move(*surface);
    return true;
  }

  std::vector<double> used_breaks(std::size_t k) const { return (k == 0 ? surface_.u : surface_.v).breaks(); }

  /// The sum of the fourth root of the fourth derivative up to each fine break, the largest over lines across.
  std::vector<double> shares(std::size_t k) const {
    const auto used = used_breaks(k);
    const auto jump = jumps(surface_, k == 0);
    const std::size_t spans = used.size() - 1;
    std::vector<double> density(spans, 0.0);
    for (std::size_t i = 0; i < spans; ++i)
      for (std::size_t l = 0; l < lines; ++l) {
        double sum = 0;
        int sides = 0;
        for (const std::size_t n : {i, i + 1}) {
          if (n == 0 || n == spans) continue;
          sum += jump[n - 1][l].norm() / (0.5 * (used[n + 1] - used[n - 1]));
          ++sides;
        }
        if (sides > 0) density[i] = std::max(density[i], std::pow(sum / sides, 0.25));
      }
    std::vector<double> result(breaks_[k].size(), 0.0);
    std::size_t span = 0;
    for (std::size_t i = 1; i < result.size(); ++i) {
      while (span + 1 < spans && breaks_[k][i - 1] >= used[span + 1]) ++span;
      result[i] = result[i - 1] + density[span] * (breaks_[k][i] - breaks_[k][i - 1]);
    }
    return result;
  }

  /// `count` knots at equal shares, in different places.
  static std::vector<int> dealt(const std::vector<double>& sum, int count) {
    const int last = int(sum.size()) - 1;
    count = std::min(count, last - 1);
    std::vector<int> result;
    for (int i = 1; i <= count; ++i) {
      const double wanted = sum.back() * i / (count + 1);
      int at = int(std::lower_bound(sum.begin(), sum.end(), wanted) - sum.begin());
      if (at > 0 && wanted - sum[std::size_t(at) - 1] < sum[std::size_t(at)] - wanted) --at;
      result.push_back(std::max(at, result.empty() ? 1 : result.back() + 1));
    }
    for (int i = count; i-- > 0;) result[std::size_t(i)] = std::min(result[std::size_t(i)], last - (count - i));
    return result;
  }

  void deal_out() {
    const std::array share = {shares(0), shares(1)};
    const double all = share[0].back() + share[1].back();
    if (!(all > 0)) return;
    // Both directions have the same number of knots for a share, as the error is the sum of both.
    const auto at = [&](double knots) {
      return Chosen{dealt(share[0], int(std::lround(knots * share[0].back() / all))),
                    dealt(share[1], int(std::lround(knots * share[1].back() / all)))};
    };
    double few = 0, many = double(best_[0].size() + best_[1].size());
    if (left(at(many)).worst > 1) return;
    while (many - few > 1) {
      const double middle = std::floor(0.5 * (few + many));
      (left(at(middle)).worst <= 1 ? many : few) = middle;
    }
    if (const Chosen chosen = at(many); controls(chosen) < controls(best_)) accept(chosen);
  }

  /// Moves the knots of one direction on both sides of the place where one was taken out, as long as less is left;
  /// true once that is no more than allowed.
  bool settle(Chosen& chosen, std::size_t k, int gap) const {
    Left now = left(chosen);
    if (now.worst > 2) return false;
    auto& moved = chosen[k];
    const auto after = std::lower_bound(moved.begin(), moved.end(), gap) - moved.begin();
    const auto first = std::size_t(std::max<std::ptrdiff_t>(after - 3, 0));
    const auto end = std::min(std::size_t(after) + 3, moved.size());
    for (int step = 4; step >= 1 && now.worst > 1 && affordable();) {
      bool better = false;
      for (std::size_t i = first; i < end && now.worst > 1; ++i)
        for (const int by : {-step, step}) {
          const int low = i == 0 ? 0 : moved[i - 1];
          const int high = i + 1 == moved.size() ? int(breaks_[k].size()) - 1 : moved[i + 1];
          const int before = moved[i];
          if (before + by <= low || before + by >= high) continue;
          moved[i] += by;
          const Left then = left(chosen);
          if (then.norm < now.norm) {
            now = then, better = true;
            break;
          }
          moved[i] = before;
        }
      if (!better) step /= 2;
    }
    return now.worst <= 1;
  }

  bool affordable() const { return asked_ * double(equations_.u().count()) * equations_.v().count() < 2e6; }

  /// Takes knots out, those first at which the third derivative jumps least over the spans beside them; the first of
  /// those that are needed in their places is tried with the others moved.
  bool take_out() {
    std::vector<KnotJump> needed;
    bool any = false;
    for (const KnotJump& knot : knots_by_jump(surface_)) {
      if (needed.size() == 4 || !affordable()) break;
      if (accept(without(knot)))
        any = true;
      else
        needed.push_back(knot);
    }
    for (std::size_t i = 0; i < needed.size() && i < 2 && !any; ++i) {
      Chosen chosen = without(needed[i]);
      any = settle(chosen, needed[i].along_u ? 0 : 1, place_of(needed[i])) && accept(chosen);
    }
    return any;
  }

  int place_of(const KnotJump& knot) const {
    const auto& breaks = breaks_[knot.along_u ? 0 : 1];
    return int(std::lower_bound(breaks.begin(), breaks.end(), knot.at) - breaks.begin());
  }

  Chosen without(const KnotJump& knot) const {
    Chosen result = best_;
    auto& list = result[knot.along_u ? 0 : 1];
    list.erase(std::find(list.begin(), list.end(), place_of(knot)));
    return result;
  }

  const NetEquations& equations_;
  const KnotChoiceOptions& options_;
  const std::array<std::vector<double>, 2> breaks_;
  Chosen best_;
  NurbsSurface surface_;  // of them
  mutable int asked_ = 0;
};

}  // namespace

std::vector<KnotJump> knots_by_jump(const NurbsSurface& surface) {
  std::vector<KnotJump> result;
  for (const bool along_u : {true, false}) {
    const auto used = (along_u ? surface.u : surface.v).breaks();
    const auto jump = jumps(surface, along_u);
    for (std::size_t n = 1; n + 1 < used.size(); ++n) {
      double most = 0;
      for (const Vec3& j : jump[n - 1]) most = std::max(most, j.norm());
      const double shorter = std::min(used[n] - used[n - 1], used[n + 1] - used[n]);
      result.push_back({along_u, used[n], most * std::pow(shorter, 3)});
    }
  }
  std::stable_sort(result.begin(), result.end(), [](const auto& a, const auto& b) { return a.jump < b.jump; });
  return result;
}

double left_over(const NetEquations& equations, const NurbsSurface& surface, double averaged) {
  return left_by(equations, surface, averaged, 1).worst;
}

std::pair<KnotVector, KnotVector> fewest_knots(const NetEquations& equations, const NurbsSurface& start,
                                               const KnotChoiceOptions& options) {
  return Choice(equations, start, options).fewest();
}

}  // namespace partscribe::fit
