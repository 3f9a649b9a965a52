#include "fit/surface/curve_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace partscribe::fit {
namespace {

template <int D>
using Places = std::vector<Eigen::Matrix<double, D, 1>>;

/// Moves the parameters of the inner places towards their feet and returns the distances.
template <int D>
std::vector<double> corrected(const NurbsCurve<D>& curve, const Places<D>& places, std::vector<double>& at) {
  std::vector<double> off(places.size(), 0.0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    Eigen::Matrix<double, D, 1> p, first, second;
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

template <int D>
bool straight(const Places<D>& places, double tolerance) {
  const auto a = places.front(), d = Eigen::Matrix<double, D, 1>(places.back() - places.front());
  for (const auto& p : places) {
    const double t = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
    if ((a + t * d - p).norm() > tolerance) return false;
  }
  return true;
}

}  // namespace

template <int D>
NurbsCurve<D> curve_through(const Places<D>& places, const std::vector<double>& at, const KnotVector& knots) {
  using Place = Eigen::Matrix<double, D, 1>;
  const int count = knots.count(), open = count - 2;
  NurbsCurve<D> curve{knots, Places<D>(std::size_t(count), Place::Zero()), {}};
  curve.points.front() = places.front(), curve.points.back() = places.back();
  if (open == 0) return curve;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(open, open);
  Eigen::Matrix<double, Eigen::Dynamic, D> right = Eigen::Matrix<double, Eigen::Dynamic, D>::Zero(open, D);
  for (std::size_t i = 0; i < places.size(); ++i) {
    BasisValues n;
    basis(knots, at[i], 0, n);
    Place rest = places[i];
    for (int k = 0; k <= knots.degree; ++k) {
      const int c = n.first + k;
      if (c == 0 || c == count - 1) rest -= n.value[0][k] * curve.points[std::size_t(c)];
    }
    for (int k = 0; k <= knots.degree; ++k) {
      const int row = n.first + k - 1;
      if (row < 0 || row >= open) continue;
      right.row(row) += n.value[0][k] * rest.transpose();
      for (int l = 0; l <= knots.degree; ++l) {
        const int column = n.first + l - 1;
        if (column >= 0 && column < open) normal(row, column) += n.value[0][k] * n.value[0][l];
      }
    }
  }
  // Spans without places between two others keep to their neighbours.
  const double small = 1e-6 * normal.trace() / open;
  for (int i = 0; i + 2 < count; ++i) {
    Place rest = Place::Zero();
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
  const Eigen::Matrix<double, Eigen::Dynamic, D> net = normal.ldlt().solve(right);
  for (int i = 0; i < open; ++i) curve.points[std::size_t(i) + 1] = net.row(i).transpose();
  return curve;
}

template <int D>
NurbsCurve<D> fitted_curve(const Places<D>& given, double tolerance) {
  const Places<D> places = denser(given, 2 * tolerance);
  if (places.size() < 4 || straight<D>(places, 0.5 * tolerance))
    return {clamped(1, {0, 1}), {places.front(), places.back()}, {}};
  std::vector<double> chords = {0};
  for (std::size_t i = 1; i < places.size(); ++i)
    chords.push_back(chords.back() + std::max((places[i] - places[i - 1]).norm(), 1e-12));
  for (double& c : chords) c /= chords.back() > 0 ? chords.back() : 1;
  std::vector<double> breaks = {0, 1};
  NurbsCurve<D> curve;
  for (int round = 0; round < 12; ++round) {
    std::vector<double> at = chords, off;
    for (int correction = 0; correction < 3; ++correction) {
      curve = curve_through<D>(places, at, clamped(3, breaks));
      off = corrected<D>(curve, places, at);
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

template NurbsCurve<2> fitted_curve(const Places<2>&, double);
template NurbsCurve<3> fitted_curve(const Places<3>&, double);
template NurbsCurve<2> curve_through(const Places<2>&, const std::vector<double>&, const KnotVector&);
template NurbsCurve<3> curve_through(const Places<3>&, const std::vector<double>&, const KnotVector&);

}  // namespace partscribe::fit
