#include "geometry/surfaces/nurbs_intersect.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "core/ensure.h"
#include "geometry/decompose.h"
#include "geometry/surfaces/nurbs_edit.h"

namespace partscribe::geometry {
namespace {

constexpr long most_pairs = 500'000;
constexpr std::size_t most_places = 5000;  // that stand alone
constexpr int most_steps = 100'000;
constexpr double most_turn = 0.3;      // rad between the ends of a step
constexpr double flattest = 1e-3;      // of the tolerance: no piece is halved below it
constexpr double parallel = 1e-5;      // rad between normals: no direction to follow
constexpr double met = 1e-10;          // of the size: on both
constexpr double least_step = 1e-3;    // of the tolerance
constexpr double largest_step = 0.05;  // of the size

// ---- smooth parts -------------------------------------------------------------------------------------------------

/// Whether a surface has a kink (or a gap) along a knot: the control polygons before and after it are not all prolonged
/// by one factor. Directions, not speeds, so that arcs of a circle are one curve.
bool is_crease(const NurbsSurface& s, bool along_u, double knot) {
  const KnotVector& t = along_u ? s.u : s.v;
  const int last = int(std::upper_bound(t.knots.begin(), t.knots.end(), knot) - t.knots.begin()) - 1;
  const int times = last + 1 - int(std::lower_bound(t.knots.begin(), t.knots.end(), knot) - t.knots.begin());
  if (times < t.degree) return false;
  if (times > t.degree) return true;
  const int at = last - t.degree, lines = (along_u ? s.v : s.u).count();
  std::vector<std::pair<Vec3, Vec3>> sides;
  double before = 0, after = 0;
  for (int line = 0; line < lines; ++line) {
    const auto place = [&](int i) { return std::size_t(along_u ? i * s.v.count() + line : line * s.v.count() + i); };
    const auto leg = [&](int from, int to, int other) {
      const double weight = s.weights.empty() ? 1 : s.weights[place(other)] / s.weights[place(at)];
      return Vec3(weight * (s.points[place(to)] - s.points[place(from)]));
    };
    sides.emplace_back(leg(at - 1, at, at - 1), leg(at, at + 1, at + 1));
    before = std::max(before, sides.back().first.norm()), after = std::max(after, sides.back().second.norm());
  }
  for (const auto& [a, b] : sides)
    if (!((before * b - after * a).norm() <= 1e-6 * before * after)) return true;
  return false;
}

/// Cut along its creases, each part over its own parameters.
std::vector<NurbsSurface> smooth_parts(const NurbsSurface& surface) {
  std::vector<NurbsSurface> parts = {with_clamped_ends(with_clamped_ends(surface, true), false)};
  for (const bool along_u : {true, false}) {
    std::vector<NurbsSurface> finer;
    for (const NurbsSurface& part : parts) {
      const KnotVector& t = along_u ? part.u : part.v;
      double from = t.low();
      for (const double knot : t.breaks())
        if (knot == t.high() || (knot > from && is_crease(part, along_u, knot))) {
          finer.push_back(part_between(part, along_u, from, knot));
          from = knot;
        }
    }
    parts = std::move(finer);
  }
  return parts;
}

// ---- halving ------------------------------------------------------------------------------------------------------

/// A piece without inner knots by its control points, which its hull is that of; halved when somebody asks.
struct HullCell {
  double u0, u1, v0, v1;
  int nu, nv;                        // control points, v running fastest
  std::vector<Eigen::Vector4d> net;  // times their weights, which stand last
  std::vector<Vec3> points = {};
  Box3 box = {};
  Vec3 normal = Vec3::Zero();  // zero for a curve
  double low = 0, high = 0;    // along the normal
  double deviation = 0;        // from a parallelogram, mm
  double spread = 0;           // of normals around the normal, rad
  std::unique_ptr<std::array<HullCell, 2>> halves = {};

  const Vec3& at(int i, int j) const { return points[std::size_t(i * nv + j)]; }
  Vec3 corner(int i, int j) const { return at(i * (nu - 1), j * (nv - 1)); }
};

/// How far rows of control points are from even steps on straight lines.
double bend_of(const HullCell& c, bool along_u) {
  double most = 0;
  for (int i = along_u ? 1 : 0; i < (along_u ? c.nu - 1 : c.nu); ++i)
    for (int j = along_u ? 0 : 1; j < (along_u ? c.nv : c.nv - 1); ++j) {
      const Vec3 &before = along_u ? c.at(i - 1, j) : c.at(i, j - 1),
                 &after = along_u ? c.at(i + 1, j) : c.at(i, j + 1);
      most = std::max(most, (before - 2 * c.at(i, j) + after).norm());
    }
  return most;
}

void measure_hull(HullCell& c) {
  c.points.clear();
  for (const auto& h : c.net) {
    c.points.push_back(h.head<3>() / h.w());
    c.box.add(c.points.back());
  }
  const Vec3 a = c.corner(0, 0), b = c.corner(1, 0), d = c.corner(0, 1), e = c.corner(1, 1);
  c.deviation = c.nu > 1 && c.nv > 1 ? 0.25 * (a - b - d + e).norm() : 0;
  for (int i = 0; i < c.nu; ++i)
    for (int j = 0; j < c.nv; ++j) {
      const double s = c.nu > 1 ? double(i) / (c.nu - 1) : 0, t = c.nv > 1 ? double(j) / (c.nv - 1) : 0;
      const Vec3 even = (1 - s) * ((1 - t) * a + t * d) + s * ((1 - t) * b + t * e);
      c.deviation = std::max(c.deviation, (c.at(i, j) - even).norm());
    }
  if (c.nu > 1 && c.nv > 1) {
    const Vec3 n = (e - a).cross(d - b);
    if (n.norm() > 0) c.normal = n.normalized();
    for (int i = 0; i + 1 < c.nu; ++i)
      for (int j = 0; j + 1 < c.nv; ++j) {
        const Vec3 own = (c.at(i + 1, j + 1) - c.at(i, j)).cross(c.at(i, j + 1) - c.at(i + 1, j));
        if (own.norm() > 0) c.spread = std::max(c.spread, (own.normalized() - c.normal).norm());
      }
  }
  c.low = std::numeric_limits<double>::infinity(), c.high = -c.low;
  for (const Vec3& p : c.points) c.low = std::min(c.low, c.normal.dot(p)), c.high = std::max(c.high, c.normal.dot(p));
}

std::vector<HullCell> hulls_of(const NurbsSurface& surface) {
  std::vector<HullCell> cells;
  for (const NurbsSurface& piece : bezier_pieces(surface)) {
    HullCell c{piece.u.low(), piece.u.high(), piece.v.low(), piece.v.high(), piece.u.count(), piece.v.count(), {}};
    for (std::size_t i = 0; i < piece.points.size(); ++i) {
      const double w = piece.weights.empty() ? 1 : piece.weights[i];
      const Vec3 p = w * piece.points[i];
      c.net.emplace_back(p.x(), p.y(), p.z(), w);
    }
    measure_hull(c);
    cells.push_back(std::move(c));
  }
  return cells;
}

std::array<HullCell, 2>& halves_of(HullCell& c) {
  if (c.halves) return *c.halves;
  bool along_u = c.nv == 1;
  if (c.nu > 1 && c.nv > 1) {
    const double bend_u = bend_of(c, true), bend_v = bend_of(c, false);
    // Where only a twist is left, across the longer sides.
    const double length_u = (c.corner(1, 0) - c.corner(0, 0)).norm(),
                 length_v = (c.corner(0, 1) - c.corner(0, 0)).norm();
    along_u = bend_u != bend_v ? bend_u > bend_v : length_u >= length_v;
  }
  const auto part = [&](bool second) {
    HullCell half{c.u0, c.u1, c.v0, c.v1, c.nu, c.nv, c.net};
    (along_u ? (second ? half.u0 : half.u1) : (second ? half.v0 : half.v1)) =
        along_u ? 0.5 * (c.u0 + c.u1) : 0.5 * (c.v0 + c.v1);
    const int count = along_u ? c.nu : c.nv, lines = along_u ? c.nv : c.nu;
    // De Casteljau's triangle leaves the second half where it was begun; from the other end it leaves the first.
    for (int l = 0; l < lines; ++l)
      for (int r = 1; r < count; ++r)
        for (int i = 0; i < count - r; ++i) {
          const auto place = [&](int k) {
            const int along = second ? k : count - 1 - k;
            return std::size_t(along_u ? along * c.nv + l : l * c.nv + along);
          };
          half.net[place(i)] = 0.5 * (half.net[place(i)] + half.net[place(i + 1)]);
        }
    measure_hull(half);
    return half;
  };
  c.halves = std::make_unique<std::array<HullCell, 2>>(std::array<HullCell, 2>{part(false), part(true)});
  return *c.halves;
}

bool beside(const HullCell& c, const HullCell& other) {
  if (c.normal.isZero()) return false;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vec3& p : other.points) low = std::min(low, c.normal.dot(p)), high = std::max(high, c.normal.dot(p));
  const double rounding = 1e-13 * (1 + c.box.low.norm() + c.box.high.norm());
  return low > c.high + rounding || high < c.low - rounding;
}

bool may_meet(const HullCell& a, const HullCell& b) {
  const double rounding = 1e-13 * (1 + a.box.low.norm() + a.box.high.norm());
  if (((a.box.low - b.box.high).array() > rounding).any() || ((b.box.low - a.box.high).array() > rounding).any())
    return false;
  return !beside(a, b) && !beside(b, a);
}

/// Calls `work(a, b)` for all pairs of flat pieces that may meet; false if there are too many, or as soon as it is.
template <class Work>
bool for_flat_pairs(HullCell& a, HullCell& b, double tolerance, long& pairs, const Work& work) {
  if (!may_meet(a, b)) return true;
  if (++pairs > most_pairs) return false;
  const double deviation = std::max(a.deviation, b.deviation);
  // Pieces that may be parallel somewhere may meet in two curves though both are flat.
  const bool once = a.normal.isZero() || b.normal.isZero() || a.normal.cross(b.normal).norm() > a.spread + b.spread;
  if (deviation <= tolerance * (once ? 1 : flattest)) return work(a, b);
  const bool first = a.deviation >= b.deviation;
  for (HullCell& half : halves_of(first ? a : b))
    if (!for_flat_pairs(first ? half : a, first ? b : half, tolerance, pairs, work)) return false;
  return true;
}

// ---- Newton -------------------------------------------------------------------------------------------------------

/// Two surfaces; a place is (u, v) on the first and (u, v) on the second.
class SplineMeeting {
 public:
  SplineMeeting(const NurbsSurface& a, const NurbsSurface& b, double tolerance, double size)
      : s_{&a, &b}, tolerance_(tolerance), size_(size) {
    for (int k = 0; k < 2; ++k) {
      low_.segment<2>(2 * k) = Vec2(s_[k]->u.low(), s_[k]->v.low());
      high_.segment<2>(2 * k) = Vec2(s_[k]->u.high(), s_[k]->v.high());
    }
  }

  double size() const { return size_; }

  IntersectionPlace place(const Eigen::Vector4d& x) const {
    return {0.5 * (s_[0]->at(x[0], x[1]) + s_[1]->at(x[2], x[3])), x.head<2>(), x.tail<2>()};
  }

  /// Near where parallelograms in place of the pieces come nearest to each other: one share after the other is chosen.
  Eigen::Vector4d start(const HullCell& a, const HullCell& b) const {
    Vec3 columns[4], off = Vec3::Zero();
    for (int k = 0; k < 2; ++k) {
      const HullCell& c = k == 0 ? a : b;
      const Vec3 corner[4] = {c.corner(0, 0), c.corner(0, 1), c.corner(1, 0), c.corner(1, 1)};
      const double sign = k == 0 ? 1 : -1;
      columns[2 * k] = sign * 0.25 * (corner[2] + corner[3] - corner[0] - corner[1]);
      columns[2 * k + 1] = sign * 0.25 * (corner[1] + corner[3] - corner[0] - corner[2]);
      off += sign * 0.25 * (corner[0] + corner[1] + corner[2] + corner[3]);
    }
    Eigen::Vector4d y = Eigen::Vector4d::Zero();
    for (int sweep = 0; sweep < 40; ++sweep)
      for (int k = 0; k < 4; ++k) {
        const double sq = columns[k].squaredNorm();
        if (!(sq > 0)) continue;
        const double next = std::clamp(y[k] - off.dot(columns[k]) / sq, -1.0, 1.0);
        off += (next - y[k]) * columns[k], y[k] = next;
      }
    const Eigen::Vector4d from(a.u0, a.v0, b.u0, b.v0), to(a.u1, a.v1, b.u1, b.v1);
    return 0.5 * (from + to) + 0.5 * y.cwiseProduct(to - from);
  }

  /// Least steps inside of both domains until both places are one; one parameter may be held.
  bool refine(Eigen::Vector4d& x, int held = -1) const {
    x = x.cwiseMax(low_).cwiseMin(high_);
    double off = gap(x);
    for (int round = 0; round < 40 && off > 1e-14 * size_; ++round) {
      Vec3 columns[4];
      const Vec3 apart = linear(x, columns);
      std::array<bool, 4> fixed{};
      if (held >= 0) fixed[std::size_t(held)] = true;
      Eigen::Vector4d step = Eigen::Vector4d::Zero();
      for (bool again = true; again;) {
        again = false;
        step = least_squares_step(columns, nullptr, apart, 0, fixed);
        for (int k = 0; k < 4; ++k)
          if ((x[k] <= low_[k] && step[k] < 0) || (x[k] >= high_[k] && step[k] > 0))
            again = fixed[std::size_t(k)] = true;
      }
      bool nearer = false;
      for (double share = 1; share > 0.05 && !nearer; share /= 2) {
        const Eigen::Vector4d next = (x + share * step).cwiseMax(low_).cwiseMin(high_);
        const double next_off = gap(next);
        if (next_off < off) x = next, off = next_off, nearer = true;
      }
      if (!nearer) break;
    }
    return off <= met * size_;
  }

  /// The unit direction of the curve at a place; false where the surfaces touch.
  bool direction(const Eigen::Vector4d& x, Vec3& t) const {
    t = normal_at(*s_[0], x[0], x[1]).cross(normal_at(*s_[1], x[2], x[3]));
    const double sine = t.norm();
    if (!(sine > parallel)) return false;
    t /= sine;
    return true;
  }

  /// On along the curve until the place is `h` farther in direction t; beyond the domains, too.
  bool advance(const Eigen::Vector4d& from, const Vec3& t, double h, Eigen::Vector4d& x) const {
    x = from;
    const Vec3 p = s_[0]->at(from[0], from[1]);
    double off = std::numeric_limits<double>::infinity();
    for (int round = 0; round < 12; ++round) {
      Vec3 columns[4];
      const Vec3 apart = linear(x, columns);
      const double behind = t.dot(s_[0]->at(x[0], x[1]) - p) - h, now = apart.norm() + std::abs(behind);
      if (now <= 1e-14 * size_ || (now <= met * size_ && !(now < 0.5 * off))) return apart.norm() <= met * size_;
      if (round > 2 && !(now < off)) return false;
      off = now;
      x += least_squares_step(columns, &t, apart, behind, {});
    }
    return false;
  }

  /// The first end of a domain that lies between two places; -1 for none. `share`: how far on the way.
  int end_between(const Eigen::Vector4d& from, const Eigen::Vector4d& to, double& share) const {
    int first = -1;
    share = 2;
    for (int k = 0; k < 4; ++k) {
      const double rounding = 1e-11 * (high_[k] - low_[k]), end = to[k] < low_[k] ? low_[k] : high_[k];
      if (to[k] >= low_[k] - rounding && to[k] <= high_[k] + rounding) continue;
      const double own = (end - from[k]) / (to[k] - from[k]);
      if (own < share) share = own, first = k;
    }
    return first;
  }
  double end_value(int k, double beyond) const { return beyond < low_[k] ? low_[k] : high_[k]; }
  Eigen::Vector4d inside(const Eigen::Vector4d& x) const { return x.cwiseMax(low_).cwiseMin(high_); }
  double tolerance() const { return tolerance_; }

 private:
  double gap(const Eigen::Vector4d& x) const { return (s_[0]->at(x[0], x[1]) - s_[1]->at(x[2], x[3])).norm(); }

  Vec3 linear(const Eigen::Vector4d& x, Vec3 columns[4]) const {
    const SurfacePoint a = s_[0]->derivatives(x[0], x[1]), b = s_[1]->derivatives(x[2], x[3]);
    columns[0] = a.du, columns[1] = a.dv, columns[2] = -b.du, columns[3] = -b.dv;
    return a.p - b.p;
  }

  /// The shortest step (in mm) that closes the gap, and, if `t` is given, goes on along it on the first surface.
  Eigen::Vector4d least_squares_step(const Vec3 columns[4], const Vec3* t, const Vec3& apart, double behind,
                                     const std::array<bool, 4>& fixed) const {
    Eigen::Matrix4d rows = Eigen::Matrix4d::Zero();
    Eigen::Vector4d scale = Eigen::Vector4d::Zero();
    for (int k = 0; k < 4; ++k) {
      // A column that vanishes belongs to a parameter of a curve that is none, or of an edge that is a point.
      const double length = columns[k].norm(), range = high_[k] - low_[k];
      if (fixed[std::size_t(k)] || !(length * range > 1e-13 * size_)) continue;
      scale[k] = 1 / length;
      rows.block<3, 1>(0, k) = columns[k] / length;
      if (t && k < 2) rows(3, k) = t->dot(columns[k]) / length;
    }
    Eigen::Vector4d right;
    right << -apart, -behind;
    Eigen::Matrix4d normal = rows.transpose() * rows;
    normal.diagonal().array() += 1e-13;
    return scale.cwiseProduct(solve_ldlt<4, 1>(normal, rows.transpose() * right));
  }

  const NurbsSurface* s_[2];
  double tolerance_, size_;
  Eigen::Vector4d low_, high_;
};

// ---- following ----------------------------------------------------------------------------------------------------

struct ChordFoot {
  double distance, share;
  Vec3 along;  // unit
};

ChordFoot foot_on_chord(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 d = b - a;
  const double sq = d.squaredNorm(), share = sq > 0 ? std::clamp((p - a).dot(d) / sq, 0.0, 1.0) : 0;
  return {(a + share * d - p).norm(), share, sq > 0 ? Vec3(d / std::sqrt(sq)) : Vec3::Zero()};
}

/// What has been followed so far, along the direction in which the first normal times the second points.
struct FollowedCurve {
  IntersectionCurve curve;
  Box3 box;
};

/// Whether a curve has passed this place towards t. What is beyond an open end has not been passed, nor what comes back
/// beside it from a sharp corner.
bool passed(const std::vector<FollowedCurve>& curves, const Vec3& p, double tolerance, const Vec3& t) {
  for (const FollowedCurve& c : curves) {
    if (((c.box.low - p).array() > tolerance).any() || ((p - c.box.high).array() > tolerance).any()) continue;
    const auto& places = c.curve.places;
    for (std::size_t i = 0; i + 1 < places.size(); ++i) {
      const ChordFoot foot = foot_on_chord(places[i].point, places[i + 1].point, p);
      const bool beyond =
          !c.curve.closed && ((i == 0 && foot.share == 0) || (i + 2 == places.size() && foot.share == 1));
      if (foot.distance <= (beyond ? least_step : 1) * tolerance && foot.along.dot(t) > 0.5) return true;
    }
  }
  return false;
}

bool on_curves(const std::vector<FollowedCurve>& curves, const Vec3& p, double tolerance) {
  for (const FollowedCurve& c : curves)
    for (std::size_t i = 0; i + 1 < c.curve.places.size(); ++i)
      if (foot_on_chord(c.curve.places[i].point, c.curve.places[i + 1].point, p).distance <= tolerance) return true;
  return false;
}

/// Places after the start, to one side; true if they come back to it.
bool follow(const SplineMeeting& m, const std::vector<FollowedCurve>& others, const Eigen::Vector4d& start, double sign,
            std::vector<IntersectionPlace>& places) {
  Eigen::Vector4d x = start;
  Vec3 t, first_t;
  if (!m.direction(x, t)) return false;
  first_t = t *= sign;
  const IntersectionPlace first = m.place(start);
  IntersectionPlace here = first;
  const double smallest = least_step * std::min(m.tolerance(), m.size());
  double h = 0.01 * m.size();
  for (int step = 0; step < most_steps && h > smallest;) {
    Eigen::Vector4d next, middle;
    Vec3 next_t;
    const auto smaller = [&] { h *= 0.5; };
    if (!m.advance(x, t, h, next)) {
      smaller();
      continue;
    }
    double share = 0;
    const int end = m.end_between(x, next, share);
    if (end >= 0) {
      // The curve leaves a domain: its place on that end is the last one.
      Eigen::Vector4d last = x + share * (next - x);
      last[end] = m.end_value(end, next[end]);
      const bool refined = m.refine(last, end);
      const IntersectionPlace place = m.place(last);
      const Vec3 way = place.point - here.point;
      const double on = way.dot(t), aside = (way - on * t).norm();
      if (!refined || on < -1e-9 * m.size() || on > 1.01 * h || aside > 0.3 * h + 1e-9 * m.size()) {
        smaller();
        continue;
      }
      if (on > smallest && h * aside > 4 * m.tolerance() * on) {
        smaller();
        continue;
      }
      if (places.empty() || way.norm() > 1e-11 * m.size())
        places.push_back(place);
      else
        places.back() = place;
      return false;
    }
    next = m.inside(next);
    if (!m.direction(next, next_t)) {
      smaller();
      continue;
    }
    next_t *= sign;
    const double turn = std::acos(std::clamp(t.dot(next_t), -1.0, 1.0));
    const IntersectionPlace there = m.place(next);
    if (turn > most_turn || h * turn > 8 * m.tolerance() || !m.advance(x, t, 0.5 * h, middle) ||
        foot_on_chord(here.point, there.point, m.place(middle).point).distance > m.tolerance()) {
      smaller();
      continue;
    }
    ++step;
    const ChordFoot back = foot_on_chord(here.point, there.point, first.point);
    if (places.size() > 2 && back.distance <= m.tolerance() && back.along.dot(first_t) > 0.7) {
      places.push_back(first);
      return true;
    }
    places.push_back(there);
    if (passed(others, there.point, m.tolerance(), sign * next_t)) return false;
    x = next, t = next_t, here = there;
    if (turn < 0.5 * most_turn && h * turn < 2 * m.tolerance()) h = std::min(1.6 * h, largest_step * m.size());
  }
  return false;
}

FollowedCurve followed(const SplineMeeting& m, const std::vector<FollowedCurve>& others, const Eigen::Vector4d& start) {
  FollowedCurve result;
  auto& places = result.curve.places;
  places.push_back(m.place(start));
  result.curve.closed = follow(m, others, start, 1, places);
  if (!result.curve.closed) {
    std::vector<IntersectionPlace> before;
    follow(m, others, start, -1, before);
    places.insert(places.begin(), before.rbegin(), before.rend());
  }
  for (const auto& p : places) result.box.add(p.point);
  return result;
}

// ---- linking ------------------------------------------------------------------------------------------------------

struct CurveEnd {
  std::size_t curve;
  bool last;
  Vec3 point, outwards;
};

CurveEnd end_of_curve(const std::vector<IntersectionCurve>& curves, std::size_t i, bool last) {
  const auto& p = curves[i].places;
  const Vec3 &end = last ? p.back().point : p.front().point, &before = last ? p[p.size() - 2].point : p[1].point;
  return {i, last, end, (end - before).normalized()};
}

/// Joins open curves whose ends are one place: the straightest first.
void link_ends(std::vector<IntersectionCurve>& curves, double tolerance) {
  for (;;) {
    std::vector<CurveEnd> ends;
    for (std::size_t i = 0; i < curves.size(); ++i)
      for (const bool last : {false, true})
        if (!curves[i].closed) ends.push_back(end_of_curve(curves, i, last));
    const CurveEnd *one = nullptr, *other = nullptr;
    double straightest = 2;
    for (std::size_t a = 0; a < ends.size(); ++a)
      for (std::size_t b = a + 1; b < ends.size(); ++b) {
        const double cosine = ends[a].outwards.dot(ends[b].outwards);
        if ((ends[a].point - ends[b].point).norm() > tolerance || cosine >= straightest) continue;
        if (ends[a].curve == ends[b].curve && curves[ends[a].curve].places.size() < 4) continue;
        straightest = cosine, one = &ends[a], other = &ends[b];
      }
    if (!one) return;
    if (one->curve == other->curve) {
      curves[one->curve].closed = true;
      continue;
    }
    auto &to = curves[one->curve].places, &from = curves[other->curve].places;
    if (!one->last) std::reverse(to.begin(), to.end());
    if (other->last) std::reverse(from.begin(), from.end());
    to.insert(to.end(), from.begin(), from.end());
    curves.erase(curves.begin() + std::ptrdiff_t(other->curve));
  }
}

/// Calls `work(meeting, x)` with a start for every pair of flat pieces that may meet; false if there are too many.
template <class Work>
bool for_meetings(const NurbsSurface& a, const NurbsSurface& b, double tolerance, const Work& work) {
  ensure(tolerance > 0, "an intersection is found within a tolerance");
  Box3 box;
  for (const auto* surface : {&a, &b})
    for (const Vec3& p : surface->points) box.add(p);
  const auto parts_a = smooth_parts(a), parts_b = smooth_parts(b);
  std::vector<std::vector<HullCell>> cells_b;
  for (const NurbsSurface& part : parts_b) cells_b.push_back(hulls_of(part));
  long pairs = 0;
  for (const NurbsSurface& one : parts_a) {
    auto cells = hulls_of(one);
    for (std::size_t k = 0; k < parts_b.size(); ++k) {
      const SplineMeeting m(one, parts_b[k], tolerance, box.diagonal());
      for (HullCell& p : cells)
        for (HullCell& q : cells_b[k])
          if (!for_flat_pairs(p, q, tolerance, pairs, [&](const HullCell& flat, const HullCell& other) {
                return work(m, m.start(flat, other));
              }))
            return false;
    }
  }
  return true;
}

bool known(const std::vector<IntersectionPlace>& places, const Vec3& p, double tolerance) {
  return std::any_of(places.begin(), places.end(), [&](const auto& q) { return (q.point - p).norm() <= tolerance; });
}

SplineIntersection isolated_meetings(const NurbsSurface& a, const NurbsSurface& b, double tolerance) {
  SplineIntersection result;
  result.complete = for_meetings(a, b, tolerance, [&](const SplineMeeting& m, Eigen::Vector4d x) {
    if (!m.refine(x)) return true;
    const IntersectionPlace place = m.place(x);
    if (!known(result.places, place.point, 2 * tolerance)) result.places.push_back(place);
    return result.places.size() < most_places;
  });
  std::stable_sort(result.places.begin(), result.places.end(),
                   [](const auto& p, const auto& q) { return p.on_a.x() < q.on_a.x(); });
  return result;
}

}  // namespace

SplineIntersection intersection_of(const NurbsSurface& a, const NurbsSurface& b, double tolerance) {
  SplineIntersection result;
  std::vector<FollowedCurve> curves;
  std::vector<IntersectionPlace> touches;
  result.complete = for_meetings(a, b, tolerance, [&](const SplineMeeting& m, Eigen::Vector4d x) {
    if (!m.refine(x)) return true;
    const IntersectionPlace place = m.place(x);
    Vec3 t;
    if (!m.direction(x, t)) {
      if (!known(touches, place.point, 2 * tolerance)) touches.push_back(place);
      return touches.size() < most_places;
    }
    if (passed(curves, place.point, 2 * tolerance, t)) return true;
    FollowedCurve curve = followed(m, curves, x);
    if (curve.curve.places.size() > 1 && curve.box.diagonal() > tolerance) curves.push_back(std::move(curve));
    return true;
  });
  for (const IntersectionPlace& touch : touches)
    if (!on_curves(curves, touch.point, 2 * tolerance)) result.places.push_back(touch);
  for (FollowedCurve& c : curves) result.curves.push_back(std::move(c.curve));
  link_ends(result.curves, tolerance);
  return result;
}

SplineIntersection intersection_of(const NurbsCurve<3>& a, const NurbsSurface& b, double tolerance) {
  return isolated_meetings(as_surface(a), b, tolerance);
}

SplineIntersection intersection_of(const NurbsCurve<3>& a, const NurbsCurve<3>& b, double tolerance) {
  return isolated_meetings(as_surface(a), as_surface(b), tolerance);
}

}  // namespace partscribe::geometry
