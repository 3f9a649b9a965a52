#include "fit/surface/spline_fit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "core/parallel.h"
#include "fit/surface/crease_knots.h"
#include "fit/surface/knot_choice.h"
#include "fit/surface/net_equations.h"
#include "geometry/points/spatial_order.h"
#include "geometry/surfaces/cubic_basis.h"

namespace partscribe::fit {
namespace {

constexpr int degree = 3;
constexpr double fairness = 1e-6;  // of the bending energy, beside the mean squared distance

/// How many points have to be averaged with each other so that noise is a small part of the tolerance.
std::size_t points_averaged(const SplineFitOptions& options) {
  return static_cast<std::size_t>(
      std::clamp(std::ceil(enough_to_average(options.noise, options.tolerance)), 6.0, 30.0));
}

/// Points in an order in which neighbours in the list are neighbours on the surface; those held come last, as they are.
std::vector<std::uint32_t> order_of(const SplineData& data, int threads) {
  std::vector<Vec3> flat;
  const std::size_t free = data.points.size() - data.held;
  for (std::size_t i = 0; i < free; ++i) flat.emplace_back(data.places[i].x(), data.places[i].y(), 0);
  auto order = spatial_order(flat, threads);
  for (std::size_t i = free; i < data.points.size(); ++i) order.push_back(static_cast<std::uint32_t>(i));
  return order;
}

SplineData reordered(const SplineData& data, const std::vector<std::uint32_t>& order) {
  SplineData result;
  for (const auto i : order) {
    result.points.push_back(data.points[i]), result.places.push_back(data.places[i]);
    if (!data.weights.empty()) result.weights.push_back(i < data.weights.size() ? data.weights[i] : 1);
  }
  result.held = data.held;
  return result;
}

/// Each span in an even number of parts that are no longer than `length`, or alone.
std::vector<double> parted(const std::vector<double>& breaks, double length) {
  std::vector<double> result = {breaks[0]};
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    const double wanted = (breaks[i + 1] - breaks[i]) / length;
    const int parts = wanted < 1.0001 ? 1 : 2 * int(std::ceil(0.5 * wanted - 1e-4));
    for (int k = 1; k < parts; ++k) result.push_back(breaks[i] + (breaks[i + 1] - breaks[i]) * k / parts);
    result.push_back(breaks[i + 1]);
  }
  return result;
}

class Fitter {
 public:
  Fitter(const SplineData& data, const SplineFitOptions& options, Context& context)
      : order_(order_of(data, context.threads)),
        data_(reordered(data, order_)),
        given_(data_.places),
        options_(options),
        context_(context),
        averaged_(std::min(points_averaged(options), data.points.size() - data.held)) {}

  std::optional<SplineFit> fit() {
    surface_.u = clamped(degree, {options_.low.x(), options_.high.x()});
    surface_.v = clamped(degree, {options_.low.y(), options_.high.y()});
    start_with_few();
    return fitted(true);
  }

  std::optional<SplineFit> fit_again(const NurbsSurface& before) {
    surface_.u = before.u, surface_.v = before.v;
    return fitted(false);
  }

 private:
  std::optional<SplineFit> fitted(bool fewest) {
    const int many = controls();
    if (!set(surface_.u, surface_.v)) return std::nullopt;
    const bool enough = refine();
    if (fewest || !enough) {
      if (!choose_knots(enough)) return std::nullopt;
    } else if (controls() > many) {
      take_out_singly();
    }
    std::vector<Vec2> places(data_.places.size());
    for (std::size_t i = 0; i < places.size(); ++i) places[order_[i]] = data_.places[i];
    return SplineFit{std::move(surface_), std::move(places), worst_};
  }

  /// An eighth of many points tell most of the knots.
  void start_with_few() {
    const std::size_t free = data_.points.size() - data_.held;
    if (free < 8000) return;
    SplineData few;
    for (std::size_t i = 0; i < free; i += 8) {
      few.points.push_back(data_.points[i]), few.places.push_back(data_.places[i]);
      if (!data_.weights.empty()) few.weights.push_back(data_.weights[i]);
    }
    Fitter rough(few, options_, context_);
    if (!rough.set(surface_.u, surface_.v)) return;
    rough.refine();
    surface_ = std::move(rough.surface_);
    look();
  }

  /// Knots are inserted until the tolerance is kept.
  bool refine() {
    const double most = std::min(double(options_.most_controls), double(data_.points.size()) / 3);
    for (int round = 0; !kept(); ++round) {
      context_.say("free form: " + std::to_string(surface_.u.count()) + " x " + std::to_string(surface_.v.count()) +
                   " control points, off by " + print_number(snapped(worst_, options_.tolerance / 1000)) + " mm");
      if (round == 40 || context_.cancelled) return false;
      auto [more_u, more_v] = refined();
      if (double(more_u.count()) * more_v.count() > most) return false;
      if (!set(more_u, more_v)) return false;
    }
    return true;
  }

  /// The equations of the points where they are now.
  void collect() {
    // So many points to a cell that a basis function, which weighs four and a third of them, averages enough.
    const Vec2 size(surface_.u.high() - surface_.u.low(), surface_.v.high() - surface_.v.low());
    const double per_cell = std::max(1.5, double(averaged_) / 4.35);
    const double dense = std::sqrt(size.x() * size.y() * per_cell / double(data_.points.size()));
    const auto fine = [&](const KnotVector& knots) {
      const auto breaks = knots.breaks();
      const double lines = std::max(16.0, std::min(4 * double(breaks.size() - 1), 32 + 2 * double(breaks.size() - 1)));
      auto result = clamped(degree, parted(breaks, std::max(dense, (breaks.back() - breaks.front()) / lines)));
      for (const auto& [at, times] : knots.multiplicities())
        for (int k = 1; k < times && at > knots.low() && at < knots.high(); ++k) result = with_knot(result, at);
      return result;
    };
    equations_.emplace(fine(surface_.u), fine(surface_.v));
    equations_->add(data_.points, data_.places, data_.weights);
  }

  bool has_lines(const KnotVector& u, const KnotVector& v) const {
    const auto includes = [](const KnotVector& fine, const KnotVector& coarse) {
      return std::includes(fine.knots.begin(), fine.knots.end(), coarse.knots.begin(), coarse.knots.end());
    };
    return includes(equations_->u(), u) && includes(equations_->v(), v);
  }

  /// Solves for a net with these knots and looks what it leaves; where the points have moved, once more.
  bool set(const KnotVector& u, const KnotVector& v) {
    for (int round = 0; round < 2; ++round) {
      if (!equations_ || !has_lines(u, v)) surface_.u = u, surface_.v = v, collect();
      auto next = equations_->solve(u, v, fairness);
      if (!next) return false;
      surface_ = std::move(*next);
      look();
      if (kept() || worst_ >= 4 * options_.tolerance) break;
    }
    return true;
  }

  /// Is the tolerance kept by distances from the feet on this surface? Near it the points go there by a few steps.
  bool kept() {
    for (int step = 0; !at_feet_ && worst_ < 4 * options_.tolerance; ++step) {
      const double before = worst_;
      look();
      at_feet_ = step == 3 || std::abs(before - worst_) < 0.02 * options_.tolerance;
    }
    return worst_ <= options_.tolerance;
  }

  /// Signed distances of the points from the surface. The points move to their feet once it is close: before, feet run
  /// together where it bends too little.
  void look() {
    std::vector<double> single(data_.points.size());
    std::vector<Vec2> feet(data_.places.size());
    parallel_for(data_.points.size(), context_.threads, [&](std::size_t begin, std::size_t end) {
      CubicBasis nu(surface_.u), nv(surface_.v);
      for (std::size_t i = begin; i < end; ++i)
        single[i] = step_to_foot(data_.points[i], data_.places[i], nu, nv, feet[i]);
    });
    mean_ = averages(single);
    worst_ = 0;
    for (const double d : mean_) worst_ = std::max(worst_, std::abs(d));
    at_feet_ = false;
    if (worst_ >= 4 * options_.tolerance) return;
    data_.places = std::move(feet);
    equations_.reset();
  }

  /// One step of Gauss and Newton to the foot of a point, and the distance from there on the plane that touches at
  /// `place`.
  double step_to_foot(const Vec3& p, const Vec2& place, CubicBasis& nu, CubicBasis& nv, Vec2& foot) const {
    nu.move_to(place.x()), nv.move_to(place.y());
    const int row = surface_.v.count();
    Vec3 r = p, du = Vec3::Zero(), dv = Vec3::Zero();
    for (int i = 0; i <= degree; ++i) {
      const Vec3* c = &surface_.points[std::size_t((nu.first + i) * row + nv.first)];
      const Vec3 line = nv.value[0] * c[0] + nv.value[1] * c[1] + nv.value[2] * c[2] + nv.value[3] * c[3];
      const Vec3 along = nv.slope[0] * c[0] + nv.slope[1] * c[1] + nv.slope[2] * c[2] + nv.slope[3] * c[3];
      r -= nu.value[i] * line, du += nu.slope[i] * line, dv += nu.value[i] * along;
    }
    const double a = du.squaredNorm(), b = du.dot(dv), c = dv.squaredNorm(), det = a * c - b * b;
    const double x = r.dot(du), y = r.dot(dv);
    foot = place;
    if (det > 1e-12 * a * c) {
      foot += Vec2((c * x - b * y) / det, (a * y - b * x) / det);
      foot.x() = std::clamp(foot.x(), surface_.u.low(), surface_.u.high());
      foot.y() = std::clamp(foot.y(), surface_.v.low(), surface_.v.high());
    }
    r -= (foot.x() - place.x()) * du + (foot.y() - place.y()) * dv;
    return std::copysign(r.norm(), r.dot(du.cross(dv)));
  }

  /// Means of as many points in turn as are to be averaged, around each; held points are compared by themselves, with
  /// the same bound as the others.
  std::vector<double> averages(const std::vector<double>& single) const {
    std::vector<double> result = single;
    const std::size_t free = single.size() - data_.held;
    std::vector<double> sums(free + 1, 0.0);
    for (std::size_t i = 0; i < free; ++i) sums[i + 1] = sums[i] + single[i];
    for (std::size_t i = 0; i < free; ++i) {
      const std::size_t from = std::min(i - std::min(i, averaged_ / 2), free - averaged_);
      result[i] = (sums[from + averaged_] - sums[from]) / double(averaged_);
    }
    for (std::size_t i = free; i < result.size(); ++i) result[i] *= options_.tolerance / options_.held_tolerance;
    return result;
  }

  /// The knots with more of them in the middle of spans in which the tolerance is not kept.
  std::pair<KnotVector, KnotVector> refined() const {
    const auto us = surface_.u.breaks(), vs = surface_.v.breaks();
    const std::size_t columns = vs.size() - 1;
    struct Cell {
      double worst = 0;
      std::vector<std::size_t> points;
    };
    std::vector<Cell> cells((us.size() - 1) * columns);
    const auto span = [](const std::vector<double>& breaks, double t) {
      const auto at = std::upper_bound(breaks.begin() + 1, breaks.end() - 1, t) - breaks.begin();
      return static_cast<std::size_t>(at - 1);
    };
    for (std::size_t i = 0; i < data_.places.size(); ++i) {
      Cell& cell = cells[span(us, data_.places[i].x()) * columns + span(vs, data_.places[i].y())];
      cell.worst = std::max(cell.worst, std::abs(mean_[i]));
      cell.points.push_back(i);
    }
    std::vector<char> split_u(us.size() - 1, 0), split_v(columns, 0);
    for (std::size_t i = 0; i + 1 < us.size(); ++i)
      for (std::size_t j = 0; j < columns; ++j) {
        const Cell& cell = cells[i * columns + j];
        if (cell.worst <= options_.tolerance) continue;
        const auto [by_u, by_v] = variation(cell.points, {us[i], vs[j]}, {us[i + 1], vs[j + 1]});
        // Across the direction in which the residuals vary, or both; long spans first.
        const double most = std::max(by_u, by_v);
        const double long_u = us[i + 1] - us[i], long_v = vs[j + 1] - vs[j];
        if (by_u >= 0.5 * most && long_u > 0.3 * long_v) split_u[i] = 1;
        if (by_v >= 0.5 * most && long_v > 0.3 * long_u) split_v[j] = 1;
        if (!split_u[i] && !split_v[j]) (long_u > long_v ? split_u[i] : split_v[j]) = 1;
      }
    return {halved(surface_.u, split_u), halved(surface_.v, split_v)};
  }

  static KnotVector halved(const KnotVector& knots, const std::vector<char>& split) {
    KnotVector result = knots;
    const auto breaks = knots.breaks();
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
      if (split[i]) result = with_knot(result, 0.5 * (breaks[i] + breaks[i + 1]));
    return result;
  }

  /// Few knots, with creases where that takes fewer; `enough`: without them the tolerance is kept.
  bool choose_knots(bool enough) {
    State refined = state();
    std::optional<State> smooth;
    if (enough) simplify(), smooth = state();
    const int many = controls();
    if (enough) restore(std::move(refined));
    const bool creased = find_creases();
    if (creased) simplify();
    if (smooth && (!creased || controls() >= many)) restore(std::move(*smooth));
    return creased || enough;
  }

  /// One multiple knot for many where that keeps the tolerance with no more control points, or at all.
  bool find_creases() {
    bool found = false;
    for (const bool along_u : {true, false})
      for (int round = 0; round < 4 && !context_.cancelled; ++round) {
        const CreaseData data{data_.points, given_, data_.weights, options_.noise};
        auto knots = crease_knots(data, surface_.u, surface_.v, along_u);
        if (!knots) break;
        State before = state();
        const bool kept_before = kept();
        const int many = controls();
        // Feet on a surface that rounds the crease do not tell where it is.
        data_.places = given_;
        equations_.reset();
        if (set(along_u ? *knots : surface_.u, along_u ? surface_.v : *knots) &&
            (kept_before ? kept() && controls() <= many : refine())) {
          found = true;
          continue;
        }
        restore(std::move(before));
        break;
      }
    return found;
  }

  /// How much of the averaged residuals of a cell depends on u alone, and on v alone: variances of means of strips.
  std::pair<double, double> variation(const std::vector<std::size_t>& points, const Vec2& low, const Vec2& high) const {
    constexpr std::size_t strips = 6;
    double sum[2][strips] = {}, count[2][strips] = {}, mean = 0;
    for (const std::size_t i : points) {
      mean += mean_[i] / double(points.size());
      for (int axis = 0; axis < 2; ++axis) {
        const double share = (data_.places[i][axis] - low[axis]) / (high[axis] - low[axis]);
        const auto strip = static_cast<std::size_t>(std::clamp(share * double(strips), 0.0, double(strips) - 1));
        sum[axis][strip] += mean_[i], count[axis][strip] += 1;
      }
    }
    double result[2] = {};
    for (std::size_t axis = 0; axis < 2; ++axis)
      for (std::size_t s = 0; s < strips; ++s)
        if (count[axis][s] > 0) result[axis] += count[axis][s] * std::pow(sum[axis][s] / count[axis][s] - mean, 2);
    return {result[0], result[1]};
  }

  struct State {
    NurbsSurface surface;
    std::vector<Vec2> places;
    double worst;
  };
  State state() const { return {surface_, data_.places, worst_}; }
  void restore(State&& state) {
    surface_ = std::move(state.surface), data_.places = std::move(state.places), worst_ = state.worst;
    at_feet_ = true;
    equations_.reset();
  }
  int controls() const { return surface_.u.count() * surface_.v.count(); }

  /// Fewer knots as long as the tolerance is kept. What the equations leave tells well enough where they are needed;
  /// the points have the last word: they get knots back where they miss them, and are asked for single ones in the end.
  void simplify() {
    bool refused = false;
    for (int round = 0; round < 3 && !context_.cancelled; ++round) {
      State before = state();
      const int many = controls();
      if (!equations_) collect();
      KnotChoiceOptions choice{0, 0.5 * double(averaged_), fairness};
      choice.allowed = options_.tolerance * std::min(1.0, left_over(*equations_, surface_, choice.averaged) / worst_);
      const auto [u, v] = fewest_knots(*equations_, surface_, choice);
      if (u.count() * v.count() >= many) break;
      if (set(u, v) && kept()) break;
      refused = true;
      if (refine() && controls() < many) continue;
      restore(std::move(before));
      break;
    }
    if (refused) take_out_singly();
  }

  void take_out_singly() {
    int needed = 0;
    for (const KnotJump& knot : knots_by_jump(surface_)) {
      if (needed == 6 || context_.cancelled) break;
      KnotVector u = surface_.u, v = surface_.v;
      auto& knots = (knot.along_u ? u : v).knots;
      knots.erase(std::find(knots.begin(), knots.end(), knot.at));
      State before = state();
      if (set(u, v) && kept()) continue;
      restore(std::move(before));
      ++needed;
    }
  }

  const std::vector<std::uint32_t> order_;  // of the points given
  SplineData data_;                         // its places are moved to the feet
  const std::vector<Vec2> given_;           // the places before that
  const SplineFitOptions& options_;
  Context& context_;
  const std::size_t averaged_;
  std::optional<NetEquations> equations_;  // of the points where they are
  NurbsSurface surface_;
  std::vector<double> mean_;  // mm, averaged signed distances of the points
  double worst_ = 0;          // the largest of them
  bool at_feet_ = false;      // the distances are those at the feet
};

}  // namespace

std::optional<SplineFit> fit_spline(const SplineData& data, const SplineFitOptions& options, Context& context) {
  if (data.points.size() < 16) return std::nullopt;
  return Fitter(data, options, context).fit();
}

std::optional<SplineFit> fit_spline_again(const SplineData& data, const NurbsSurface& before,
                                          const SplineFitOptions& options, Context& context) {
  return Fitter(data, options, context).fit_again(before);
}

}  // namespace partscribe::fit
