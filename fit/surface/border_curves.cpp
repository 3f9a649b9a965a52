#include "fit/surface/border_curves.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/number.h"

namespace partscribe::fit {
namespace {

double off_line(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  const double t = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
  return (a + t * d - p).norm();
}

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

/// Cubic with its ends in the first and the last place.
NurbsCurve<2> solved(const std::vector<Vec2>& places, const std::vector<double>& at, const KnotVector& t) {
  const int count = t.count(), open = count - 2;
  NurbsCurve<2> curve{t, std::vector<Vec2>(std::size_t(count), Vec2::Zero()), {}};
  curve.points.front() = places.front(), curve.points.back() = places.back();
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(open, open);
  Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(open, 2);
  for (std::size_t i = 0; i < places.size(); ++i) {
    BasisValues n;
    basis(t, at[i], 0, n);
    Vec2 rest = places[i];
    for (int k = 0; k <= t.degree; ++k) {
      const int c = n.first + k;
      if (c == 0 || c == count - 1) rest -= n.value[0][k] * curve.points[std::size_t(c)];
    }
    for (int k = 0; k <= t.degree; ++k) {
      const int row = n.first + k - 1;
      if (row < 0 || row >= open) continue;
      right.row(row) += n.value[0][k] * rest.transpose();
      for (int l = 0; l <= t.degree; ++l) {
        const int column = n.first + l - 1;
        if (column >= 0 && column < open) normal(row, column) += n.value[0][k] * n.value[0][l];
      }
    }
  }
  // Spans without places between two others keep to their neighbours.
  const double small = 1e-6 * normal.trace() / open;
  for (int i = 0; i + 2 < count; ++i) {
    Vec2 rest = Vec2::Zero();
    const double share[3] = {1, -2, 1};
    for (int k = 0; k < 3; ++k)
      if (i + k == 0 || i + k == count - 1) rest -= share[k] * curve.points[std::size_t(i + k)];
    for (int k = 0; k < 3; ++k) {
      const int row = i + k - 1;
      if (row < 0 || row >= open) continue;
      right.row(row) += small * share[k] * rest.transpose();
      for (int l = 0; l < 3; ++l)
        if (const int column = i + l - 1; column >= 0 && column < open)
          normal(row, column) += small * share[k] * share[l];
    }
  }
  const Eigen::MatrixX2d net = normal.ldlt().solve(right);
  for (int i = 0; i < open; ++i) curve.points[std::size_t(i) + 1] = net.row(i).transpose();
  return curve;
}

/// Moves the parameters of the inner places towards their feet and returns the distances.
std::vector<double> corrected(const NurbsCurve<2>& curve, const std::vector<Vec2>& places, std::vector<double>& at) {
  std::vector<double> off(places.size(), 0.0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    Vec2 p, first, second;
    for (int round = 0; round < 3; ++round) {
      curve.derivatives(at[i], p, first, second);
      if (i == 0 || i + 1 == places.size()) break;
      const double slope = first.squaredNorm() + std::max((p - places[i]).dot(second), 0.0);
      at[i] = std::clamp(at[i] - (p - places[i]).dot(first) / std::max(slope, 1e-300), curve.t.low(), curve.t.high());
    }
    off[i] = (curve.at(at[i]) - places[i]).norm();
  }
  return off;
}

/// The same line with places so close that no span of a curve is without some.
std::vector<Vec2> denser(const std::vector<Vec2>& places, double step) {
  std::vector<Vec2> result = {places.front()};
  for (std::size_t i = 1; i < places.size(); ++i) {
    const Vec2 d = places[i] - places[i - 1];
    const int pieces = std::clamp(static_cast<int>(std::ceil(d.norm() / step)), 1, 1000);
    for (int k = 1; k <= pieces; ++k) result.push_back(k == pieces ? places[i] : Vec2(places[i - 1] + k * d / pieces));
  }
  return result;
}

NurbsCurve<2> fitted(const std::vector<Vec2>& given, double tolerance) {
  const std::vector<Vec2> places = denser(given, 2 * tolerance);
  const auto straight = [&] {
    for (const Vec2& p : places)
      if (off_line(p, places.front(), places.back()) > 0.5 * tolerance) return false;
    return true;
  };
  if (places.size() < 4 || straight()) return {clamped(1, {0, 1}), {places.front(), places.back()}, {}};
  std::vector<double> chords = {0};
  for (std::size_t i = 1; i < places.size(); ++i)
    chords.push_back(chords.back() + std::max((places[i] - places[i - 1]).norm(), 1e-12));
  for (double& c : chords) c /= chords.back() > 0 ? chords.back() : 1;
  std::vector<double> breaks = {0, 1};
  NurbsCurve<2> curve;
  for (int round = 0; round < 12; ++round) {
    std::vector<double> at = chords, off;
    for (int correction = 0; correction < 3; ++correction) {
      curve = solved(places, at, clamped(3, breaks));
      off = corrected(curve, places, at);
    }
    std::vector<char> failing(breaks.size() - 1, 0);
    for (std::size_t i = 0; i < places.size(); ++i)
      if (off[i] > tolerance)
        failing[std::size_t(std::upper_bound(breaks.begin() + 1, breaks.end() - 1, at[i]) - breaks.begin() - 1)] = 1;
    std::vector<double> finer = {0};
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
      if (failing[i]) finer.push_back(0.5 * (breaks[i] + breaks[i + 1]));
      finer.push_back(breaks[i + 1]);
    }
    if (finer.size() == breaks.size() || finer.size() > places.size() / 2) break;
    breaks = finer;
  }
  return curve;
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
    result.push_back(fitted(piece, tolerance));
  }
  return result;
}

}  // namespace partscribe::fit
