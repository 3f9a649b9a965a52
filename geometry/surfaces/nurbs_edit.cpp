#include "geometry/surfaces/nurbs_edit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/ensure.h"

namespace partscribe::geometry {
namespace {

/// Control points along one parameter as rows. Across a row stand the coordinates of one point, or of all points at
/// that place of a surface's other parameter; times their weights, and these behind them, where there are any.
struct ControlRows {
  KnotVector t;
  Eigen::MatrixXd rows;
  int size = 3;  // of a point
  bool rational = false;
};

template <int D>
ControlRows rows_of(const NurbsCurve<D>& curve) {
  ControlRows c{curve.t, {}, D + (curve.weights.empty() ? 0 : 1), !curve.weights.empty()};
  c.rows.resize(Eigen::Index(curve.points.size()), c.size);
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const double w = c.rational ? curve.weights[i] : 1;
    c.rows.row(Eigen::Index(i)).template head<D>() = w * curve.points[i].transpose();
    if (c.rational) c.rows(Eigen::Index(i), D) = w;
  }
  return c;
}

template <int D>
NurbsCurve<D> curve_from(const ControlRows& c) {
  NurbsCurve<D> curve{c.t, {}, {}};
  for (Eigen::Index i = 0; i < c.rows.rows(); ++i) {
    const double w = c.rational ? c.rows(i, D) : 1;
    curve.points.push_back(c.rows.row(i).template head<D>().transpose() / w);
    if (c.rational) curve.weights.push_back(w);
  }
  return curve;
}

std::size_t place_in(const NurbsSurface& s, bool along_u, Eigen::Index along, Eigen::Index across) {
  return std::size_t(along_u ? along * s.v.count() + across : across * s.v.count() + along);
}

ControlRows rows_of(const NurbsSurface& s, bool along_u) {
  ControlRows c{along_u ? s.u : s.v, {}, s.weights.empty() ? 3 : 4, !s.weights.empty()};
  const Eigen::Index lines = (along_u ? s.v : s.u).count();
  c.rows.resize(c.t.count(), lines * c.size);
  for (Eigen::Index i = 0; i < c.rows.rows(); ++i)
    for (Eigen::Index j = 0; j < lines; ++j) {
      const std::size_t from = place_in(s, along_u, i, j);
      const double w = c.rational ? s.weights[from] : 1;
      c.rows.block<1, 3>(i, j * c.size) = w * s.points[from].transpose();
      if (c.rational) c.rows(i, j * c.size + 3) = w;
    }
  return c;
}

/// The surface that has these rows along one parameter, and its own knots along the other.
NurbsSurface surface_from(const ControlRows& c, const NurbsSurface& old, bool along_u) {
  NurbsSurface s{along_u ? c.t : old.u, along_u ? old.v : c.t, {}, {}};
  const Eigen::Index lines = c.rows.cols() / c.size;
  s.points.resize(std::size_t(c.rows.rows() * lines));
  if (c.rational) s.weights.resize(s.points.size());
  for (Eigen::Index i = 0; i < c.rows.rows(); ++i)
    for (Eigen::Index j = 0; j < lines; ++j) {
      const std::size_t to = place_in(s, along_u, i, j);
      const double w = c.rational ? c.rows(i, j * c.size + 3) : 1;
      s.points[to] = c.rows.block<1, 3>(i, j * c.size).transpose() / w;
      if (c.rational) s.weights[to] = w;
    }
  return s;
}

int first_knot(const KnotVector& t, double knot) {
  return int(std::lower_bound(t.knots.begin(), t.knots.end(), knot) - t.knots.begin());
}

int last_knot(const KnotVector& t, double knot) {
  return int(std::upper_bound(t.knots.begin(), t.knots.end(), knot) - t.knots.begin()) - 1;
}

int multiplicity(const KnotVector& t, double knot) { return last_knot(t, knot) + 1 - first_knot(t, knot); }

void insert_knot(ControlRows& c, double t) {
  const auto shares = insertion_shares(c.t, t);
  Eigen::MatrixXd rows(c.rows.rows() + 1, c.rows.cols());
  const Eigen::Index last = c.rows.rows() - 1;
  for (Eigen::Index i = 0; i <= last + 1; ++i) {
    const double share = shares[std::size_t(i)];
    // A share of one or none takes a row as it is, so that knots of full multiplicity add nothing but a copy.
    if (share == 0 || share == 1)
      rows.row(i) = c.rows.row(share == 0 ? i - 1 : i);
    else
      rows.row(i) = (1 - share) * c.rows.row(i - 1) + share * c.rows.row(std::min(i, last));
  }
  c.rows = std::move(rows), c.t = with_knot(c.t, t);
}

void insert_until(ControlRows& c, double t, int times) {
  while (multiplicity(c.t, t) < times) insert_knot(c, t);
}

/// What is over [from, to], both of which are knots of a multiplicity of at least the degree.
ControlRows rows_between(const ControlRows& c, double from, double to) {
  const int p = c.t.degree, first = last_knot(c.t, from), last = first_knot(c.t, to);
  ControlRows result{{p, std::vector<double>(std::size_t(p) + 1, from)}, {}, c.size, c.rational};
  auto& knots = result.t.knots;
  knots.insert(knots.end(), c.t.knots.begin() + first + 1, c.t.knots.begin() + last);
  knots.insert(knots.end(), std::size_t(p) + 1, to);
  result.rows = c.rows.middleRows(first - p, last - first + p);
  return result;
}

ControlRows part_of_rows(ControlRows c, double from, double to) {
  ensure(c.t.low() <= from && from < to && to <= c.t.high(), "a part of a spline lies inside of its domain");
  insert_until(c, from, c.t.degree);
  insert_until(c, to, c.t.degree);
  return rows_between(c, from, to);
}

ControlRows clamped_rows(const ControlRows& c) { return part_of_rows(c, c.t.low(), c.t.high()); }

std::vector<ControlRows> pieces_of_rows(ControlRows c) {
  const auto breaks = c.t.breaks();
  for (const double t : breaks) insert_until(c, t, c.t.degree);
  std::vector<ControlRows> pieces;
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) pieces.push_back(rows_between(c, breaks[i], breaks[i + 1]));
  return pieces;
}

/// The polar form of the polynomial over a span at as many arguments as the degree (de Boor's steps, one for each).
Eigen::RowVectorXd blossom(const ControlRows& c, int span, const std::vector<double>& arguments) {
  const int p = c.t.degree;
  const auto& k = c.t.knots;
  Eigen::MatrixXd d = c.rows.middleRows(span - p, p + 1);
  for (int r = 1; r <= p; ++r)
    for (int j = p; j >= r; --j) {
      const std::size_t low = std::size_t(span - p + j), high = std::size_t(span + j - r + 1);
      const double share = (arguments[std::size_t(r - 1)] - k[low]) / (k[high] - k[low]);
      d.row(j) = (1 - share) * d.row(j - 1) + share * d.row(j);
    }
  return d.row(p);
}

/// Control point i over finer knots is the mean of the polar form at all but one of the p + 1 knots i + 1 .. i + p + 1.
/// Of a clamped one.
ControlRows elevated_rows(const ControlRows& c) {
  const int p = c.t.degree;
  ensure(p < most_spline_degree, "a B-spline's degree is at most 25");
  ControlRows result{{p + 1, {}}, {}, c.size, c.rational};
  for (const auto& [knot, times] : c.t.multiplicities())
    result.t.knots.insert(result.t.knots.end(), std::size_t(times) + 1, knot);
  const auto& k = result.t.knots;
  result.rows.resize(result.t.count(), c.rows.cols());
  for (int i = 0; i < result.t.count(); ++i) {
    const double from = k[std::size_t(i) + 1], to = k[std::size_t(i + p) + 1];
    // Any span between these knots has the same polar form there; a gap's control points belong to one side of it.
    int span = c.t.span(0.5 * (from + to));
    if (from == to) span = k[std::size_t(i)] < from ? first_knot(c.t, from) - 1 : last_knot(c.t, from);
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(c.rows.cols());
    for (int left_out = 0; left_out <= p; ++left_out) {
      std::vector<double> arguments;
      for (int j = 0; j <= p; ++j)
        if (j != left_out) arguments.push_back(k[std::size_t(i + 1 + j)]);
      sum += blossom(c, span, arguments);
    }
    result.rows.row(i) = sum / (p + 1);
  }
  return result;
}

ControlRows elevated_rows(const ControlRows& c, int times) {
  ControlRows result = clamped_rows(c);
  for (int i = 0; i < times; ++i) result = elevated_rows(result);
  return result;
}

/// A bound of how far two are apart that have the same knots. With weights, a / w - q = ((a - b) - q (w - x)) / w,
/// where q = b / x lies among the control points of the second.
double deviation_bound(const ControlRows& one, const ControlRows& other) {
  const Eigen::Index size = one.size, dimension = one.rational ? size - 1 : size, lines = one.rows.cols() / size;
  const auto for_all = [&](const auto& work) {
    for (Eigen::Index i = 0; i < one.rows.rows(); ++i)
      for (Eigen::Index j = 0; j < lines; ++j) work(i, j * size);
  };
  double most = 0;
  if (!one.rational) {
    for_all([&](Eigen::Index i, Eigen::Index j) {
      most = std::max(most, (one.rows.block(i, j, 1, size) - other.rows.block(i, j, 1, size)).norm());
    });
    return most;
  }
  double least_weight = std::numeric_limits<double>::infinity(), reach = 0;
  Eigen::RowVectorXd middle = Eigen::RowVectorXd::Zero(dimension);
  bool positive = true;
  for_all([&](Eigen::Index i, Eigen::Index j) {
    least_weight = std::min(least_weight, one.rows(i, j + dimension));
    positive = positive && other.rows(i, j + dimension) > 0;
    middle += other.rows.block(i, j, 1, dimension) / other.rows(i, j + dimension) / double(one.rows.rows() * lines);
  });
  if (!positive) return std::numeric_limits<double>::infinity();
  for_all([&](Eigen::Index i, Eigen::Index j) {
    reach = std::max(reach, (other.rows.block(i, j, 1, dimension) / other.rows(i, j + dimension) - middle).norm());
  });
  for_all([&](Eigen::Index i, Eigen::Index j) {
    const double weight = one.rows(i, j + dimension) - other.rows(i, j + dimension);
    const Eigen::RowVectorXd off =
        one.rows.block(i, j, 1, dimension) - other.rows.block(i, j, 1, dimension) - weight * middle;
    most = std::max(most, (off.norm() + reach * std::abs(weight)) / least_weight);
  });
  return most;
}

/// With one knot fewer. The equations P_i = a_i Q_i + (1 - a_i) Q_i-1 of its insertion are one more than there are
/// unknown Q; n' P = 0 says whether they agree. Where not, each is given up by the same distance.
/// `error`: that distance, as all coordinates of a row have it, weights too.
ControlRows rows_without(const ControlRows& c, double knot, double& error) {
  const int p = c.t.degree, r = last_knot(c.t, knot), s = multiplicity(c.t, knot), first = r - p, last = r - s;
  ControlRows result{c.t, Eigen::MatrixXd(c.rows.rows() - 1, c.rows.cols()), c.size, c.rational};
  result.t.knots.erase(result.t.knots.begin() + r);
  auto& q = result.rows;
  q.topRows(first) = c.rows.topRows(first);
  if (s > p) {
    // A gap: its two sides become one point.
    q.bottomRows(q.rows() - first) = c.rows.bottomRows(q.rows() - first);
    q.row(first - 1) = 0.5 * (c.rows.row(first - 1) + c.rows.row(first));
    error = 0.5 * (c.rows.row(first - 1) - c.rows.row(first)).norm();
    return result;
  }
  q.bottomRows(q.rows() - last) = c.rows.bottomRows(q.rows() - last);
  const std::size_t equations = std::size_t(last - first) + 1;
  std::vector<double> a(equations), n(equations, 1.0);
  double total = 0;
  Eigen::MatrixXd b = c.rows.middleRows(first, Eigen::Index(equations));
  for (std::size_t i = 0; i < equations; ++i) {
    const std::size_t k = std::size_t(first) + i;
    a[i] = (knot - c.t.knots[k]) / (c.t.knots[k + std::size_t(p) + 1] - c.t.knots[k]);
    if (i > 0) n[i] = -n[i - 1] * a[i - 1] / (1 - a[i]);
    total += std::abs(n[i]);
  }
  b.row(0) -= (1 - a.front()) * q.row(first - 1);
  b.row(last - first) -= a.back() * q.row(last);
  Eigen::RowVectorXd off = Eigen::RowVectorXd::Zero(c.rows.cols());
  for (std::size_t i = 0; i < equations; ++i) off += n[i] / total * b.row(Eigen::Index(i));
  error = off.norm();
  for (std::size_t i = 0; i < equations; ++i) b.row(Eigen::Index(i)) -= (n[i] > 0 ? 1 : -1) * off;
  // From both sides to the middle, so that no rounding grows over all of them.
  const int middle = (last - first + 1) / 2;
  for (int i = 0; i < middle; ++i) {
    Eigen::RowVectorXd row = b.row(i);
    if (i > 0) row -= (1 - a[std::size_t(i)]) * q.row(first + i - 1);
    q.row(first + i) = row / a[std::size_t(i)];
  }
  for (int i = last - first; i > middle; --i) {
    Eigen::RowVectorXd row = b.row(i);
    if (i < last - first) row -= a[std::size_t(i)] * q.row(first + i);
    q.row(first + i - 1) = row / (1 - a[std::size_t(i)]);
  }
  return result;
}

/// Removes knots as long as the bound of what moved since the beginning allows.
struct KnotRemover {
  ControlRows given, now;
  std::vector<double> removed = {};
  double deviation = 0;

  bool take(const ControlRows& next, double knot, double tolerance) {
    ControlRows refined = next;
    insert_knot(refined, knot);
    for (const double t : removed) insert_knot(refined, t);
    const double bound = deviation_bound(given, refined);
    if (!(bound <= tolerance)) return false;
    now = next, deviation = bound;
    removed.push_back(knot);
    return true;
  }

  void take_at(double knot, int times, double tolerance) {
    ensure(knot > now.t.low() && knot < now.t.high(), "knots are removed inside of the domain");
    double error = 0;
    for (int i = 0; i < times && multiplicity(now.t, knot) > 0; ++i)
      if (!take(rows_without(now, knot, error), knot, tolerance)) return;
  }

  void take_all(double tolerance) {
    std::vector<double> kept;
    for (;;) {
      double least = std::numeric_limits<double>::infinity(), best = 0;
      ControlRows next;
      for (const double knot : now.t.breaks()) {
        if (knot <= now.t.low() || knot >= now.t.high()) continue;
        if (std::find(kept.begin(), kept.end(), knot) != kept.end()) continue;
        double error = 0;
        ControlRows without = rows_without(now, knot, error);
        if (error < least) least = error, best = knot, next = std::move(without);
      }
      if (!std::isfinite(least)) return;
      if (!take(next, best, tolerance)) kept.push_back(best);
    }
  }
};

KnotVector knots_backwards(const KnotVector& t) {
  KnotVector result{t.degree, {t.knots.rbegin(), t.knots.rend()}};
  for (double& knot : result.knots) knot = t.low() + t.high() - knot;
  return result;
}

std::optional<ControlRows> wrapped_rows(const ControlRows& given, double tolerance) {
  const ControlRows c = clamped_rows(given);
  const int p = c.t.degree;
  const double low = c.t.low(), high = c.t.high();
  for (int m = 1; m <= p; ++m) {
    std::vector<double> once(std::size_t(m), low);  // the knots of one period
    once.insert(once.end(), c.t.knots.begin() + p + 1, c.t.knots.end() - p - 1);
    const int period = int(once.size()), count = period + p + 1 - m;
    ControlRows wrapped{{p, {}}, Eigen::MatrixXd(count, c.rows.cols()), c.size, c.rational};
    auto& k = wrapped.t.knots;
    for (int i = 0; i <= count + p; ++i) {
      const int shifted = i - (p + 1 - m), turns = shifted >= 0 ? shifted / period : -((period - 1 - shifted) / period);
      // The domain's ends are to be met exactly.
      const double knot = once[std::size_t(shifted - turns * period)];
      k.push_back(turns == 1 && knot == low ? high : knot + turns * (high - low));
    }
    for (int i = 0; i < count; ++i) {
      const std::vector<double> arguments(k.begin() + i + 1, k.begin() + i + 1 + p);
      const int span = c.t.span(0.5 * (arguments.front() + arguments.back()));
      wrapped.rows.row(i) = blossom(c, span, arguments);
    }
    const ControlRows open = wrapped;
    for (int i = 0; i < count - period; ++i) {
      const Eigen::RowVectorXd mean = 0.5 * (wrapped.rows.row(i) + wrapped.rows.row(i + period));
      wrapped.rows.row(i) = wrapped.rows.row(i + period) = mean;
    }
    if (deviation_bound(open, wrapped) <= tolerance) return wrapped;
  }
  return std::nullopt;
}

template <class Spline>
KnotsRemoved<Spline> said(const KnotRemover& remover, Spline spline) {
  return {std::move(spline), int(remover.removed.size()), remover.deviation};
}

KnotRemover remover_of(const ControlRows& rows) { return {rows, rows}; }

}  // namespace

template <int D>
KnotsRemoved<NurbsCurve<D>> without_knot(const NurbsCurve<D>& curve, double t, int times, double tolerance) {
  KnotRemover remover = remover_of(rows_of(curve));
  remover.take_at(t, times, tolerance);
  return said(remover, curve_from<D>(remover.now));
}

KnotsRemoved<NurbsSurface> without_knot(const NurbsSurface& surface, bool along_u, double t, int times,
                                        double tolerance) {
  KnotRemover remover = remover_of(rows_of(surface, along_u));
  remover.take_at(t, times, tolerance);
  return said(remover, surface_from(remover.now, surface, along_u));
}

template <int D>
KnotsRemoved<NurbsCurve<D>> without_spare_knots(const NurbsCurve<D>& curve, double tolerance) {
  KnotRemover remover = remover_of(rows_of(curve));
  remover.take_all(tolerance);
  return said(remover, curve_from<D>(remover.now));
}

KnotsRemoved<NurbsSurface> without_spare_knots(const NurbsSurface& surface, double tolerance) {
  KnotsRemoved<NurbsSurface> result{surface};
  for (const bool along_u : {true, false}) {
    KnotRemover remover = remover_of(rows_of(result.spline, along_u));
    remover.take_all(tolerance - result.deviation);
    result.spline = surface_from(remover.now, result.spline, along_u);
    result.removed += int(remover.removed.size()), result.deviation += remover.deviation;
  }
  return result;
}

template <int D>
NurbsCurve<D> with_higher_degree(const NurbsCurve<D>& curve, int times) {
  return curve_from<D>(elevated_rows(rows_of(curve), times));
}

NurbsSurface with_higher_degree(const NurbsSurface& surface, bool along_u, int times) {
  return surface_from(elevated_rows(rows_of(surface, along_u), times), surface, along_u);
}

template <int D>
NurbsCurve<D> part_between(const NurbsCurve<D>& curve, double from, double to) {
  return curve_from<D>(part_of_rows(rows_of(curve), from, to));
}

NurbsSurface part_between(const NurbsSurface& surface, bool along_u, double from, double to) {
  return surface_from(part_of_rows(rows_of(surface, along_u), from, to), surface, along_u);
}

template <int D>
std::pair<NurbsCurve<D>, NurbsCurve<D>> split_at(const NurbsCurve<D>& curve, double t) {
  return {part_between(curve, curve.t.low(), t), part_between(curve, t, curve.t.high())};
}

std::pair<NurbsSurface, NurbsSurface> split_at(const NurbsSurface& surface, bool along_u, double t) {
  const KnotVector& k = along_u ? surface.u : surface.v;
  return {part_between(surface, along_u, k.low(), t), part_between(surface, along_u, t, k.high())};
}

template <int D>
std::vector<NurbsCurve<D>> bezier_pieces(const NurbsCurve<D>& curve) {
  std::vector<NurbsCurve<D>> pieces;
  for (const ControlRows& rows : pieces_of_rows(rows_of(curve))) pieces.push_back(curve_from<D>(rows));
  return pieces;
}

std::vector<NurbsSurface> bezier_pieces(const NurbsSurface& surface) {
  std::vector<NurbsSurface> pieces;
  for (const ControlRows& rows : pieces_of_rows(rows_of(surface, true))) {
    const NurbsSurface strip = surface_from(rows, surface, true);
    for (const ControlRows& piece : pieces_of_rows(rows_of(strip, false)))
      pieces.push_back(surface_from(piece, strip, false));
  }
  return pieces;
}

template <int D>
NurbsCurve<D> reversed(const NurbsCurve<D>& curve) {
  return {knots_backwards(curve.t),
          {curve.points.rbegin(), curve.points.rend()},
          {curve.weights.rbegin(), curve.weights.rend()}};
}

NurbsSurface reversed(const NurbsSurface& surface, bool along_u) {
  NurbsSurface result = surface;
  KnotVector& t = along_u ? result.u : result.v;
  t = knots_backwards(t);
  const Eigen::Index count = t.count(), lines = (along_u ? surface.v : surface.u).count();
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < lines; ++j) {
      const std::size_t to = place_in(surface, along_u, i, j), from = place_in(surface, along_u, count - 1 - i, j);
      result.points[to] = surface.points[from];
      if (!surface.weights.empty()) result.weights[to] = surface.weights[from];
    }
  return result;
}

NurbsCurve<3> iso_curve(const NurbsSurface& surface, bool along_u, double at) {
  const ControlRows c = rows_of(surface, !along_u);
  BasisValues n;
  basis(c.t, at, 0, n);
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(c.rows.cols());
  for (int i = 0; i <= c.t.degree; ++i) sum += n.value[0][i] * c.rows.row(n.first + i);
  ControlRows line{along_u ? surface.u : surface.v, {}, c.size, c.rational};
  line.rows = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      sum.data(), sum.size() / c.size, c.size);
  return curve_from<3>(line);
}

NurbsCurve<3> in_space(const NurbsCurve<2>& curve) {
  NurbsCurve<3> result{curve.t, {}, curve.weights};
  for (const Vec2& p : curve.points) result.points.emplace_back(p.x(), p.y(), 0);
  return result;
}

NurbsSurface as_surface(const NurbsCurve<3>& curve) { return {curve.t, {0, {0, 1}}, curve.points, curve.weights}; }

template <int D>
NurbsCurve<D> with_clamped_ends(const NurbsCurve<D>& curve) {
  return curve_from<D>(clamped_rows(rows_of(curve)));
}

NurbsSurface with_clamped_ends(const NurbsSurface& surface, bool along_u) {
  return surface_from(clamped_rows(rows_of(surface, along_u)), surface, along_u);
}

template <int D>
std::optional<NurbsCurve<D>> with_wrapped_knots(const NurbsCurve<D>& curve, double tolerance) {
  const auto rows = wrapped_rows(rows_of(curve), tolerance);
  return rows ? std::optional(curve_from<D>(*rows)) : std::nullopt;
}

std::optional<NurbsSurface> with_wrapped_knots(const NurbsSurface& surface, bool along_u, double tolerance) {
  const auto rows = wrapped_rows(rows_of(surface, along_u), tolerance);
  return rows ? std::optional(surface_from(*rows, surface, along_u)) : std::nullopt;
}

#define PARTSCRIBE_NURBS_EDIT(D)                                                                \
  template KnotsRemoved<NurbsCurve<D>> without_knot(const NurbsCurve<D>&, double, int, double); \
  template KnotsRemoved<NurbsCurve<D>> without_spare_knots(const NurbsCurve<D>&, double);       \
  template NurbsCurve<D> with_higher_degree(const NurbsCurve<D>&, int);                         \
  template NurbsCurve<D> part_between(const NurbsCurve<D>&, double, double);                    \
  template std::pair<NurbsCurve<D>, NurbsCurve<D>> split_at(const NurbsCurve<D>&, double);      \
  template std::vector<NurbsCurve<D>> bezier_pieces(const NurbsCurve<D>&);                      \
  template NurbsCurve<D> reversed(const NurbsCurve<D>&);                                        \
  template NurbsCurve<D> with_clamped_ends(const NurbsCurve<D>&);                               \
  template std::optional<NurbsCurve<D>> with_wrapped_knots(const NurbsCurve<D>&, double)
PARTSCRIBE_NURBS_EDIT(2);
PARTSCRIBE_NURBS_EDIT(3);
#undef PARTSCRIBE_NURBS_EDIT

}  // namespace partscribe::geometry
