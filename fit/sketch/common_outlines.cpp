#include "fit/sketch/common_outlines.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "core/number.h"
#include "core/statistics.h"

namespace partscribe::fit {
namespace {

constexpr std::size_t least_points = 20, most_points = 700;

Vec2 turned(const Vec2& p, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p.x() - s * p.y(), s * p.x() + c * p.y()};
}

/// Signed, from the box between two corners.
double from_box(const Vec2& p, const Vec2& low, const Vec2& high) {
  const Vec2 q = (low - p).cwiseMax(p - high);
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

/// Distances from one outline, many of them.
class Ruler {
 public:
  explicit Ruler(const CommonOutline& o)
      : o_(o),
        cosine_(std::cos(-o.angle)),
        sine_(std::sin(-o.angle)),
        radius_(o.radius()),
        low_(o.low + Vec2::Constant(radius_)),
        high_(o.high - Vec2::Constant(radius_)) {}

  double operator()(const Vec2& p) const {
    const Vec2 q(cosine_ * p.x() - sine_ * p.y(), sine_ * p.x() + cosine_ * p.y());
    if (o_.form == OutlineForm::ell)
      return std::max(from_box(q, o_.low, o_.high), -from_box(q, o_.inner, Vec2::Constant(1e300)));
    const double d = from_box(q, low_, high_) - radius_;
    return o_.form == OutlineForm::link ? std::max({d, o_.eye - (q - low_).norm(), o_.eye - (q - high_).norm()}) : d;
  }

 private:
  const CommonOutline& o_;
  double cosine_, sine_, radius_;
  Vec2 low_, high_;  // middles of the corners' rounds
};

template <class T>
std::vector<T> spread(const std::vector<T>& all) {
  const std::size_t step = (all.size() + most_points - 1) / most_points;
  std::vector<T> result;
  for (std::size_t i = 0; i < all.size(); i += step) result.push_back(all[i]);
  return result;
}

/// What was seen, and what an outline costs that is to explain it.
class Seen {
 public:
  explicit Seen(const OutlineData& data)
      : walls_(spread(data.walls)), ends_(spread(data.ends)), band_(data.band), outward_(data.outward) {
    for (const auto& w : walls_) low_ = low_.cwiseMin(w.position), high_ = high_.cwiseMax(w.position);
    for (const Vec2& e : ends_) low_ = low_.cwiseMin(e), high_ = high_.cwiseMax(e);
    end_share_ = double(data.ends.size()) / double(ends_.size());
    wall_share_ = double(data.walls.size()) / double(walls_.size());
    if (wide_enough()) find_empty_cells(data.ends);
  }

  /// Or no outline fits in.
  bool wide_enough() const { return (high_ - low_).minCoeff() > 2 * band_; }

  double size() const { return (high_ - low_).maxCoeff(); }

  double cost(const CommonOutline& o) const {
    constexpr double outlier = 4.5, outside = 2, unfilled = 0.3, by_area = 0.1, along = 0.85;
    constexpr double impossible = 1e300;
    if (((o.high - o.low).array() < 2 * band_).any()) return impossible;
    if (o.form == OutlineForm::ell &&
        (((o.inner - o.low).array() < 2 * band_).any() || ((o.high - o.inner).array() < 2 * band_).any()))
      return impossible;
    if (o.form == OutlineForm::link && (o.eye < 2 * band_ || o.eye > o.radius() - 2 * band_)) return impossible;
    const Ruler distance(o);
    // the others are convex: none is another one turned inside out
    const bool tells_side = outward_ && o.form == OutlineForm::ell;
    double walls = 0, ends = 0;
    for (const auto& w : walls_) {
      const double u = 2.5 * distance(w.position) / band_, off = std::min(0.5 * u * u, outlier);
      const auto faces_along = [&] {
        const double rise = distance(w.position + band_ * w.normal) - distance(w.position - band_ * w.normal);
        return (tells_side ? rise : std::abs(rise)) >= along * 2 * band_;
      };
      walls += off < outlier && faces_along() ? off : outlier;
    }
    for (const Vec2& e : ends_) ends += outside * std::clamp(distance(e) / band_ - 0.5, 0.0, 1.0);
    double empty = 0;
    for (const Vec2& c : empty_) empty += unfilled * per_cell_ * std::clamp(0.5 - distance(c) / cell_, 0.0, 1.0);
    const double area = by_area * double(ends_.size()) * o.area() / (high_ - low_).prod();
    return wall_share_ * walls + end_share_ * (ends + area) + empty;
  }

  /// Directions in which most walls face, modulo a right angle, and that in which the end faces extend.
  std::vector<double> angles() const {
    constexpr std::size_t bins = 45, most = 3;
    constexpr double quarter = pi / 2;
    std::array<double, bins> count = {};
    for (const auto& w : walls_) {
      const double turn = std::atan2(w.normal.y(), w.normal.x()) / quarter;
      ++count[std::min(bins - 1, static_cast<std::size_t>((turn - std::floor(turn)) * bins))];
    }
    std::vector<std::pair<double, double>> modes;
    for (std::size_t i = 0; i < bins; ++i) {
      const double before = count[(i + bins - 1) % bins], here = count[i], after = count[(i + 1) % bins];
      if (here >= before && here > after)
        modes.emplace_back(-(before + here + after), (double(i) + 0.5) * quarter / bins);
    }
    std::sort(modes.begin(), modes.end());
    std::vector<double> result;
    for (std::size_t i = 0; i < std::min(most, modes.size()); ++i) result.push_back(modes[i].second);
    Vec2 mean = Vec2::Zero();
    for (const Vec2& e : ends_) mean += e / double(ends_.size());
    double xx = 0, xy = 0, yy = 0;
    for (const Vec2& e : ends_) {
      const Vec2 d = e - mean;
      xx += d.x() * d.x(), xy += d.x() * d.y(), yy += d.y() * d.y();
    }
    result.push_back(0.5 * std::atan2(2 * xy, xx - yy));
    return result;
  }

  /// Around nearly all that was seen.
  CommonOutline around(OutlineForm form, double angle) const {
    std::array<std::vector<double>, 2> places;
    const auto add = [&](const Vec2& p) {
      const Vec2 q = turned(p, -angle);
      places[0].push_back(q.x()), places[1].push_back(q.y());
    };
    for (const auto& w : walls_) add(w.position);
    for (const Vec2& e : ends_) add(e);
    CommonOutline o;
    o.form = form, o.angle = angle;
    for (int k = 0; k < 2; ++k) o.low[k] = quantile(places[k], 0.02), o.high[k] = quantile(places[k], 0.98);
    o.inner = 0.5 * (o.low + o.high);
    o.round = 0.2 * (o.high - o.low).minCoeff(), o.eye = 0.5 * o.radius();
    return o;
  }

 private:
  /// Middles of the cells, somewhat beyond all that was seen too, in which no end face was.
  void find_empty_cells(const std::vector<Vec2>& ends) {
    const Vec2 margin = 0.3 * (high_ - low_), low = low_ - margin, whole = high_ + margin - low;
    constexpr double least_per_cell = 2, most_cells = 1500;
    per_cell_ = std::max(least_per_cell, double(ends.size()) / most_cells);
    cell_ = std::sqrt(per_cell_ * (high_ - low_).prod() / double(ends.size()));
    const auto nx = static_cast<std::size_t>(whole.x() / cell_) + 1,
               ny = static_cast<std::size_t>(whole.y() / cell_) + 1;
    std::vector<bool> filled(nx * ny, false);
    for (const Vec2& e : ends) {
      // Of many points the bounds are those of a selection: an outlier may lie anywhere.
      const Vec2 at = (e - low) / cell_;
      if ((at.array() < 0).any() || at.x() >= double(nx) || at.y() >= double(ny)) continue;
      filled[static_cast<std::size_t>(at.y()) * nx + static_cast<std::size_t>(at.x())] = true;
    }
    for (std::size_t y = 0; y < ny; ++y)
      for (std::size_t x = 0; x < nx; ++x)
        if (!filled[y * nx + x]) empty_.emplace_back(low + cell_ * Vec2(double(x) + 0.5, double(y) + 0.5));
  }

  std::vector<PlanePoint> walls_;
  std::vector<Vec2> ends_;
  std::vector<Vec2> empty_;
  double cell_ = 0;      // mm
  double per_cell_ = 0;  // points of the end faces, on the average
  double band_;
  bool outward_;
  Vec2 low_ = Vec2::Constant(1e300), high_ = -low_;
  double end_share_ = 1, wall_share_ = 1;
};

using Change = std::function<void(CommonOutline&, double)>;

/// About its own middle: wherever the part stands, its sides stay beside what they explain.
void turn(CommonOutline& o, double angle) {
  const Vec2 middle = 0.5 * (o.low + o.high), shift = turned(turned(middle, o.angle), -(o.angle + angle)) - middle;
  o.angle += angle, o.low += shift, o.high += shift, o.inner += shift;
}

/// What may change of an outline, and how far a first step takes it.
std::vector<std::pair<Change, double>> changes_of(OutlineForm form, double size) {
  const double step = 0.08 * size;
  std::vector<std::pair<Change, double>> result = {{turn, 0.04}};
  for (int k = 0; k < 2; ++k) {
    result.emplace_back([k](CommonOutline& o, double by) { o.low[k] += by; }, step);
    result.emplace_back([k](CommonOutline& o, double by) { o.high[k] += by; }, step);
  }
  if (form == OutlineForm::rounded) result.emplace_back([](CommonOutline& o, double by) { o.round += by; }, step);
  if (form == OutlineForm::link) result.emplace_back([](CommonOutline& o, double by) { o.eye += by; }, step);
  for (int k = 0; k < 2 && form == OutlineForm::ell; ++k)
    result.emplace_back([k](CommonOutline& o, double by) { o.inner[k] += by; }, step);
  return result;
}

/// Down to the nearest minimum, change by change, in steps that become half as long when none of them helps.
void descend(CommonOutline& o, const Seen& seen) {
  constexpr int halvings = 7, most_rounds = 60;
  const auto changes = changes_of(o.form, seen.size());
  double scale = 1;
  o.cost = seen.cost(o);
  for (int round = 0, halved = 0; round < most_rounds && halved < halvings; ++round) {
    bool better = false;
    for (const auto& [change, step] : changes)
      for (const double way : {step, -step}) {
        CommonOutline next = o;
        change(next, scale * way);
        next.cost = seen.cost(next);
        if (!(next.cost < o.cost)) continue;
        o = next, better = true;
        break;
      }
    if (!better) scale /= 2, ++halved;
  }
}

bool round_ends(OutlineForm form) { return form == OutlineForm::slot || form == OutlineForm::link; }

ProfileSegment line(const Vec2& from, const Vec2& to) {
  ProfileSegment s;
  s.start = s.point = from, s.end = to, s.direction = (to - from).normalized();
  return s;
}

ProfileSegment arc(const Vec2& center, const Vec2& from, const Vec2& to, double sweep) {
  ProfileSegment s;
  s.arc = true, s.center = center, s.radius = (from - center).norm(), s.start = from, s.end = to, s.sweep = sweep;
  return s;
}

}  // namespace

double CommonOutline::radius() const {
  const double most = 0.5 * (high - low).minCoeff();
  return form == OutlineForm::rounded ? std::clamp(round, 0.0, most) : round_ends(form) ? most : 0;
}

double CommonOutline::area() const {
  const Vec2 missing = (high - inner).cwiseMax(0.0);
  const double holes = form == OutlineForm::link ? 2 * pi * eye * eye : 0;
  return (high - low).prod() - (form == OutlineForm::ell ? missing.prod() : (4 - pi) * radius() * radius()) - holes;
}

double CommonOutline::distance(const Vec2& p) const { return Ruler(*this)(p); }

std::vector<Vec2> CommonOutline::end_centres() const {
  if (!round_ends(form)) return {};
  const Vec2 r = Vec2::Constant(radius());
  return {turned(low + r, angle), turned(high - r, angle)};
}

LoopPieces CommonOutline::loop() const {
  LoopPieces result;
  result.name = "outline";
  const auto at = [&](double x, double y) { return turned({x, y}, angle); };
  if (form == OutlineForm::ell) {
    const std::array<Vec2, 6> corners = {at(low.x(), low.y()),     at(high.x(), low.y()),   at(high.x(), inner.y()),
                                         at(inner.x(), inner.y()), at(inner.x(), high.y()), at(low.x(), high.y())};
    for (std::size_t k = 0; k < 6; ++k) result.segments.push_back(line(corners[k], corners[(k + 1) % 6]));
    return result;
  }
  const double r = radius(), tiny = 1e-9 * (high - low).maxCoeff();
  const std::array<Vec2, 4> corners = {Vec2(low.x(), low.y()), Vec2(high.x(), low.y()), Vec2(high.x(), high.y()),
                                       Vec2(low.x(), high.y())};
  const std::array<Vec2, 4> ways = {Vec2(1, 0), Vec2(0, 1), Vec2(-1, 0), Vec2(0, -1)};
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec2 &way = ways[k], &next = ways[(k + 1) % 4], &corner = corners[(k + 1) % 4];
    const Vec2 from = corners[k] + r * way, to = corner - r * way;
    if ((to - from).norm() > tiny) result.segments.push_back(line(turned(from, angle), turned(to, angle)));
    if (!(r > 0)) continue;
    const Vec2 center = to + r * next, leave = center + r * way;
    auto bend = arc(turned(center, angle), turned(to, angle), turned(leave, angle), pi / 2);
    auto* last = result.segments.empty() ? nullptr : &result.segments.back();
    if (last && last->arc && (last->center - bend.center).norm() < tiny)
      last->end = bend.end, last->sweep += bend.sweep;
    else
      result.segments.push_back(bend);
  }
  // A round end that the loop begins in the middle of.
  auto& s = result.segments;
  if (s.size() > 1 && s.front().arc && s.back().arc && (s.front().center - s.back().center).norm() < tiny) {
    s.front().start = s.back().start, s.front().sweep += s.back().sweep;
    s.pop_back();
  }
  return result;
}

std::vector<CommonOutline> common_outlines(const OutlineData& data) {
  if (data.walls.size() < least_points || data.ends.size() < least_points || !(data.band > 0)) return {};
  const Seen seen(data);
  std::vector<CommonOutline> result;
  if (!seen.wide_enough()) return result;
  for (const OutlineForm form :
       {OutlineForm::rectangle, OutlineForm::rounded, OutlineForm::slot, OutlineForm::link, OutlineForm::ell}) {
    CommonOutline best;
    best.cost = 1e300;
    for (const double angle : seen.angles())
      for (int quarter = 0; quarter < (form == OutlineForm::ell ? 4 : 1); ++quarter) {
        CommonOutline o = seen.around(form, angle + quarter * pi / 2);
        descend(o, seen);
        if (o.cost < best.cost) best = o;
      }
    const bool as_slot = form == OutlineForm::rounded && best.radius() > 0.48 * (best.high - best.low).minCoeff();
    if (best.cost < 1e300 && !as_slot) result.push_back(best);
  }
  std::stable_sort(result.begin(), result.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
  return result;
}

}  // namespace partscribe::fit
