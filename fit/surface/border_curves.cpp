#include "fit/surface/border_curves.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/number.h"
#include "fit/surface/curve_crossings.h"
#include "fit/surface/curve_fit.h"

namespace partscribe::fit {
namespace {

/// Where a closed polyline is after a length along it.
class Walk {
 public:
  explicit Walk(const std::vector<Vec2>& places) : places_(places), along_{0} {
    for (std::size_t i = 0; i < places.size(); ++i)
      along_.push_back(along_.back() + (places[(i + 1) % places.size()] - places[i]).norm());
  }
  double length() const { return along_.back(); }
  double before(std::size_t i) const { return along_[i]; }
  Vec2 at(double s) const {
    s = std::fmod(s + 2 * length(), length());
    const auto next =
        static_cast<std::size_t>(std::upper_bound(along_.begin() + 1, along_.end() - 1, s) - along_.begin());
    const Vec2 &a = places_[next - 1], &b = places_[next % places_.size()];
    const double piece = along_[next] - along_[next - 1];
    return piece > 0 ? Vec2(a + (s - along_[next - 1]) / piece * (b - a)) : a;
  }

 private:
  const std::vector<Vec2>& places_;
  std::vector<double> along_;
};

/// Places where the outline turns sharply, ascending.
std::vector<std::size_t> corners_of(const std::vector<Vec2>& places, double reach) {
  const Walk walk(places);
  if (walk.length() < 8 * reach) return {};
  std::vector<double> turn(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double s = walk.before(i);
    // Straight lines over half of the reach on both sides: a zigzag is no corner.
    const Vec2 before = walk.at(s - 0.25 * reach) - walk.at(s - reach),
               after = walk.at(s + reach) - walk.at(s + 0.25 * reach);
    if (before.norm() < 1e-12 || after.norm() < 1e-12) continue;
    turn[i] = std::abs(std::atan2(before.x() * after.y() - before.y() * after.x(), before.dot(after)));
  }
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (turn[i] < 0.7) continue;
    bool sharpest = true;
    for (std::size_t k = 0; k < places.size() && sharpest; ++k) {
      const double apart = std::abs(walk.before(k) - walk.before(i));
      if (std::min(apart, walk.length() - apart) < reach)
        sharpest = turn[k] < turn[i] || (turn[k] == turn[i] && k >= i);
    }
    if (sharpest) result.push_back(i);
  }
  return result;
}

/// Takes the places between two shares of a polyline out of it, and one more at either end; its own ends stay.
void cut_short(std::vector<Vec2>& piece, double from, double to) {
  std::vector<double> along = {0};
  for (std::size_t i = 1; i < piece.size(); ++i) along.push_back(along.back() + (piece[i] - piece[i - 1]).norm());
  const auto after = [&](double share) {
    return std::lower_bound(along.begin(), along.end(), share * along.back()) - along.begin();
  };
  const auto last = static_cast<std::ptrdiff_t>(piece.size()) - 1;
  const std::ptrdiff_t first_out = std::max<std::ptrdiff_t>(after(from) - 1, 1),
                       end_out = std::min(after(to) + 1, last);
  if (first_out < end_out) piece.erase(piece.begin() + first_out, piece.begin() + end_out);
}

/// A zigzag of the places can make their curves cross, themselves or each other beside a corner: there the places are
/// left out.
void uncross(std::vector<std::vector<Vec2>>& pieces, std::vector<NurbsCurve<2>>& curves, double tolerance) {
  for (int round = 0; round < 8; ++round) {
    std::vector<const NurbsCurve<2>*> list;
    for (const auto& curve : curves) list.push_back(&curve);
    const auto crossings = crossings_of(list);
    if (crossings.empty()) return;
    std::set<std::size_t> changed;
    for (const auto& [curve, share] : crossings) {
      changed.insert(curve.begin(), curve.end());
      if (curve[0] == curve[1] && std::abs(share[0] - share[1]) < 0.5)
        cut_short(pieces[curve[0]], std::min(share[0], share[1]), std::max(share[0], share[1]));
      else
        for (std::size_t k = 0; k < 2; ++k)
          share[k] < 0.5 ? cut_short(pieces[curve[k]], 0, share[k]) : cut_short(pieces[curve[k]], share[k], 1);
    }
    for (const auto c : changed) curves[c] = fitted_curve(pieces[c], tolerance);
  }
}

}  // namespace

std::vector<NurbsCurve<2>> border_curves(const std::vector<Vec2>& places, double tolerance) {
  auto corners = corners_of(places, 12 * tolerance);
  if (corners.empty()) {
    // Any place; the one that lies lowest does not depend on where the list begins.
    const auto lowest = std::min_element(places.begin(), places.end(), [](const Vec2& a, const Vec2& b) {
      return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
    });
    corners = {static_cast<std::size_t>(lowest - places.begin())};
  }
  std::vector<std::vector<Vec2>> pieces;
  std::vector<NurbsCurve<2>> result;
  for (std::size_t c = 0; c < corners.size(); ++c) {
    const std::size_t from = corners[c], to = corners[(c + 1) % corners.size()];
    std::vector<Vec2> piece = {places[from]};
    for (std::size_t i = from; piece.size() == 1 || i != to;) {
      i = (i + 1) % places.size();
      piece.push_back(places[i]);
    }
    // A line needs two ends: what is closed by itself is no line.
    if (corners.size() == 1 && piece.size() < 4) return {};
    result.push_back(fitted_curve(piece, tolerance));
    pieces.push_back(std::move(piece));
  }
  uncross(pieces, result, tolerance);
  return result;
}

NurbsCurve<2> held_in(NurbsCurve<2> curve, const Vec2& low, const Vec2& high, double most) {
  const auto inside = [&](const Vec2& p) { return Vec2(p.cwiseMax(low).cwiseMin(high)); };
  const auto beyond = [&](const Vec2& p) { return (inside(p) - p).norm(); };
  // The distance of a polygon from its curve falls to a quarter with each halving of the spans.
  for (int round = 0; round < 16; ++round) {
    std::vector<double> more;
    const auto& knots = curve.t.knots;
    const auto degree = static_cast<std::size_t>(curve.t.degree);
    for (std::size_t i = 0; i < curve.points.size(); ++i) {
      double mean = 0;
      for (std::size_t k = 1; k <= degree; ++k) mean += knots[i + k] / double(degree);
      if (beyond(curve.points[i]) <= most + beyond(curve.at(mean))) continue;
      for (std::size_t k = i; k <= i + degree; ++k)
        if (knots[k] < knots[k + 1]) more.push_back(0.5 * (knots[k] + knots[k + 1]));
    }
    if (more.empty()) break;
    std::sort(more.begin(), more.end());
    more.erase(std::unique(more.begin(), more.end()), more.end());
    for (const double t : more) curve = with_knot(curve, t);
  }
  for (Vec2& p : curve.points) p = inside(p);
  return curve;
}

}  // namespace partscribe::fit
