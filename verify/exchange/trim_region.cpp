#include "verify/exchange/trim_region.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace partscribe::verify {
namespace {

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Farthest that p lies from the line through a and b; from a if they coincide.
double off_chord(const Vec2& p, const Vec2& a, const Vec2& b) {
  const double length = (b - a).norm();
  return length > 0 ? std::abs(cross(b - a, p - a)) / length : (p - a).norm();
}

/// The parameter between t0 and t1 where the second coordinate turns, by golden section.
double turning_point(const TrimCurve& curve, double t0, double t1, bool highest) {
  constexpr double golden = 0.6180339887498949;
  auto height = [&](double t) { return highest ? curve.at(t).y() : -curve.at(t).y(); };
  double a = t1 - golden * (t1 - t0), b = t0 + golden * (t1 - t0), fa = height(a), fb = height(b);
  for (int i = 0; i < 60; ++i)
    if (fa > fb)
      t1 = b, b = a, fb = fa, a = t1 - golden * (t1 - t0), fa = height(a);
    else
      t0 = a, a = b, fa = fb, b = t0 + golden * (t1 - t0), fb = height(b);
  return 0.5 * (t0 + t1);
}

}  // namespace

TrimRegion::TrimRegion(std::vector<std::vector<TrimCurve>> loops) {
  // Samples of every curve first: they give the extent on which "fine" depends.
  struct Run {
    std::uint32_t curve;
    std::vector<double> t;
    std::vector<Vec2> p;
  };
  std::vector<std::vector<Run>> runs(loops.size());
  const double infinity = std::numeric_limits<double>::infinity();
  low_ = Vec2(infinity, infinity), high_ = -low_;
  for (std::size_t l = 0; l < loops.size(); ++l)
    for (auto& curve : loops[l]) {
      Run run;
      run.curve = static_cast<std::uint32_t>(curves_.size());
      const int steps = curve.straight ? 1 : 24;
      for (int i = 0; i <= steps; ++i) run.t.push_back(curve.first + (curve.last - curve.first) * i / steps);
      for (const double k : curve.kinks)
        for (int i = 0; i < 4; ++i) {
          const double t = k + (curve.last - curve.first) * 1e-3 * i;
          if (t > std::min(curve.first, curve.last) && t < std::max(curve.first, curve.last)) run.t.push_back(t);
        }
      std::sort(run.t.begin(), run.t.end());
      if (curve.first > curve.last) std::reverse(run.t.begin(), run.t.end());
      for (const double t : run.t) run.p.push_back(curve.at(t));
      for (const auto& p : run.p) low_ = low_.cwiseMin(p), high_ = high_.cwiseMax(p);
      curves_.push_back(std::move(curve));
      runs[l].push_back(std::move(run));
    }
  const double size = (high_ - low_).norm();
  fine_ = 2e-4 * size;
  for (auto& loop : runs) {
    // A gap of rounding between two curves would let a ray through.
    for (std::size_t i = 0; i < loop.size(); ++i) {
      Vec2 &end = loop[i].p.back(), &start = loop[(i + 1) % loop.size()].p.front();
      if ((end - start).norm() < 1e-3 * size) end = start = Vec2(0.5 * (end + start));
    }
    for (const auto& run : loop) {
      const TrimCurve& curve = curves_[run.curve];
      if (curve.straight) {
        add_piece(run.curve, run.t.front(), run.p.front(), run.t.back(), run.p.back(), 99);
        continue;
      }
      // Put the turning points among the samples.
      std::vector<double> t{run.t[0]};
      std::vector<Vec2> p{run.p[0]};
      for (std::size_t i = 1; i < run.t.size(); ++i) {
        if (i + 1 < run.t.size() && (run.p[i].y() - run.p[i - 1].y()) * (run.p[i + 1].y() - run.p[i].y()) < 0) {
          const double turn = turning_point(curve, run.t[i - 1], run.t[i + 1], run.p[i].y() > run.p[i - 1].y());
          t.push_back(turn), p.push_back(curve.at(turn));
          continue;
        }
        t.push_back(run.t[i]), p.push_back(run.p[i]);
      }
      for (std::size_t i = 1; i < t.size(); ++i) add_piece(run.curve, t[i - 1], p[i - 1], t[i], p[i], 0);
    }
  }
  for (const auto& piece : pieces_) low_ = low_.cwiseMin(piece.a), high_ = high_.cwiseMax(piece.b);

  const std::size_t strips = std::max<std::size_t>(1, pieces_.size() / 2);
  auto strip_of = [&](double y) {
    const double extent = high_.y() - low_.y();
    const double at = extent > 0 ? (y - low_.y()) / extent * static_cast<double>(strips) : 0;
    return std::min(strips - 1, static_cast<std::size_t>(std::max(0.0, at)));
  };
  bucket_start_.assign(strips + 1, 0);
  for (const auto& piece : pieces_)
    for (std::size_t s = strip_of(piece.a.y()); s <= strip_of(piece.b.y()); ++s) ++bucket_start_[s + 1];
  for (std::size_t s = 0; s < strips; ++s) bucket_start_[s + 1] += bucket_start_[s];
  bucket_.resize(bucket_start_.back());
  std::vector<std::uint32_t> fill(bucket_start_.begin(), bucket_start_.end() - 1);
  for (std::uint32_t i = 0; i < pieces_.size(); ++i)
    for (std::size_t s = strip_of(pieces_[i].a.y()); s <= strip_of(pieces_[i].b.y()); ++s) bucket_[fill[s]++] = i;
}

void TrimRegion::add_piece(std::uint32_t curve, double t0, const Vec2& a, double t1, const Vec2& b, int depth) {
  double slack = 0;
  if (!curves_[curve].straight) {
    const Vec2 middle = curves_[curve].at(0.5 * (t0 + t1));
    for (const double share : {0.25, 0.5, 0.75})
      slack = std::max(slack, off_chord(curves_[curve].at(t0 + share * (t1 - t0)), a, b));
    // Between the ends the middle must lie in height too, or the halves would not be monotone.
    const bool between = (middle.y() - a.y()) * (b.y() - middle.y()) >= 0;
    if (slack > fine_ && depth < 12 && between) {
      add_piece(curve, t0, a, 0.5 * (t0 + t1), middle, depth + 1);
      add_piece(curve, 0.5 * (t0 + t1), middle, t1, b, depth + 1);
      return;
    }
    slack = 2 * slack + 1e-12 * (high_ - low_).norm();
  }
  if (a.y() <= b.y())
    pieces_.push_back({a, b, t0, t1, slack, curve});
  else
    pieces_.push_back({b, a, t1, t0, slack, curve});
}

bool TrimRegion::left_of(const Vec2& p, const Piece& piece) const {
  const double side = cross(piece.b - piece.a, p - piece.a);  // positive left of the upward chord
  if (piece.slack == 0) return side > 0;
  if (std::abs(side) > piece.slack * (piece.b - piece.a).norm()) return side > 0;
  // Between chord and curve: find the place of this height on the curve itself.
  double low = piece.ta, high = piece.tb;
  const TrimCurve& curve = curves_[piece.curve];
  for (int i = 0; i < 60 && low != high; ++i) {
    const double middle = 0.5 * (low + high);
    if (middle == low || middle == high) break;
    (curve.at(middle).y() <= p.y() ? low : high) = middle;
  }
  return p.x() < curve.at(0.5 * (low + high)).x();
}

bool TrimRegion::contains(const Vec2& p) const {
  if (!(p.y() >= low_.y() && p.y() <= high_.y() && p.x() >= low_.x() && p.x() <= high_.x())) return false;
  const std::size_t strips = bucket_start_.size() - 1;
  const double extent = high_.y() - low_.y();
  const double at = extent > 0 ? (p.y() - low_.y()) / extent * static_cast<double>(strips) : 0;
  const std::size_t strip = std::min(strips - 1, static_cast<std::size_t>(std::max(0.0, at)));
  bool inside = false;
  for (std::uint32_t i = bucket_start_[strip]; i < bucket_start_[strip + 1]; ++i) {
    const Piece& piece = pieces_[bucket_[i]];
    if (p.y() < piece.a.y() || p.y() >= piece.b.y()) continue;
    const double right = std::max(piece.a.x(), piece.b.x()) + piece.slack;
    const double left = std::min(piece.a.x(), piece.b.x()) - piece.slack;
    if (p.x() >= right) continue;
    if (p.x() < left || left_of(p, piece)) inside = !inside;
  }
  return inside;
}

}  // namespace partscribe::verify
