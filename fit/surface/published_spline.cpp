#include "fit/surface/published_spline.h"

#include <algorithm>
#include <cmath>

#include "core/ensure.h"

namespace partscribe::fit {
namespace {

/// The normal equations of one line of data: symmetric, positive definite, with a band as wide as the degree.
class BandedSystem {
 public:
  BandedSystem(const KnotVector& knots, const std::vector<double>& parameters)
      : knots_(knots), parameters_(parameters), n_(knots.count()), band_(knots.degree) {
    factor_.assign(static_cast<std::size_t>(n_ * (band_ + 1)), 0);
    BasisValues b;
    for (const double t : parameters) {
      basis(knots_, t, 0, b);
      for (int i = 0; i <= band_; ++i)
        for (int j = 0; j <= i; ++j) at(b.first + i, b.first + j) += b.value[0][i] * b.value[0][j];
    }
    // Control points that no place tells are to lie in line with their neighbours.
    const double faint = 1e-9 * static_cast<double>(parameters.size()) / n_;
    for (int k = 1; k + 1 < n_ && band_ >= 2; ++k) {
      constexpr double w[3] = {1, -2, 1};
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j <= i; ++j) at(k - 1 + i, k - 1 + j) += faint * w[i] * w[j];
    }
    for (int i = 0; i < n_; ++i) at(i, i) += 1e-3 * faint;
    // Cholesky's factor in place.
    for (int i = 0; i < n_; ++i)
      for (int j = std::max(0, i - band_); j <= i; ++j) {
        double sum = at(i, j);
        for (int k = std::max(0, i - band_); k < j; ++k)
          if (k >= j - band_) sum -= at(i, k) * at(j, k);
        at(i, j) = i == j ? std::sqrt(std::max(sum, 1e-300)) : sum / at(j, j);
      }
  }

  /// Control points for the values at the parameters.
  std::vector<Vec3> solve(const std::vector<Vec3>& values) const {
    std::vector<Vec3> x(static_cast<std::size_t>(n_), Vec3::Zero());
    BasisValues b;
    for (std::size_t k = 0; k < values.size(); ++k) {
      basis(knots_, parameters_[k], 0, b);
      for (int i = 0; i <= band_; ++i) x[std::size_t(b.first + i)] += b.value[0][i] * values[k];
    }
    for (int i = 0; i < n_; ++i) {
      for (int k = std::max(0, i - band_); k < i; ++k) x[std::size_t(i)] -= at(i, k) * x[std::size_t(k)];
      x[std::size_t(i)] /= at(i, i);
    }
    for (int i = n_ - 1; i >= 0; --i) {
      for (int k = i + 1; k <= std::min(n_ - 1, i + band_); ++k) x[std::size_t(i)] -= at(k, i) * x[std::size_t(k)];
      x[std::size_t(i)] /= at(i, i);
    }
    return x;
  }

 private:
  double& at(int i, int j) { return factor_[static_cast<std::size_t>(i * (band_ + 1) + j - i + band_)]; }
  double at(int i, int j) const { return factor_[static_cast<std::size_t>(i * (band_ + 1) + j - i + band_)]; }
  const KnotVector& knots_;
  const std::vector<double>& parameters_;
  int n_, band_;
  std::vector<double> factor_;  // rows of the lower triangle, the diagonal last
};

/// Places of a line where the error is above the tolerance and at least as large as at both neighbours.
std::vector<std::size_t> local_maxima(const std::vector<double>& errors, double tolerance) {
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const bool above_last = i == 0 || errors[i] >= errors[i - 1];
    const bool above_next = i + 1 == errors.size() || errors[i] > errors[i + 1];
    if (errors[i] > tolerance && above_last && above_next) result.push_back(i);
  }
  return result;
}

/// A knot in the middle of the span at t, or of the nearest one that holds at least four parameters; false where no
/// span does.
bool insert_near(KnotVector& knots, const std::vector<double>& parameters, double t) {
  const auto breaks = knots.breaks();
  double best = -1, least = 2;
  for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
    const auto held = std::lower_bound(parameters.begin(), parameters.end(), breaks[k + 1]) -
                      std::lower_bound(parameters.begin(), parameters.end(), breaks[k]);
    if (held < 4) continue;
    const double off = std::max({0.0, breaks[k] - t, t - breaks[k + 1]});
    if (off < least) least = off, best = 0.5 * (breaks[k] + breaks[k + 1]);
  }
  if (best < 0) return false;
  knots.knots.insert(std::upper_bound(knots.knots.begin(), knots.knots.end(), best), best);
  return true;
}

}  // namespace

std::vector<double> parameters_of(const std::vector<Vec3>& places, Parameters kind) {
  std::vector<double> result = {0};
  for (std::size_t i = 1; i < places.size(); ++i) {
    const double step = (places[i] - places[i - 1]).norm();
    result.push_back(result.back() + (kind == Parameters::uniform        ? 1
                                      : kind == Parameters::chord_length ? step
                                                                         : std::sqrt(step)));
  }
  const double whole = result.back();
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = whole > 0 ? result[i] / whole : static_cast<double>(i) / std::max(1.0, double(result.size() - 1));
  return result;
}

KnotVector equal_spans(int controls, int order) {
  ensure(controls >= order && order >= 2, "as many control points as the order, at least");
  std::vector<double> breaks;
  const int spans = controls - order + 1;
  for (int i = 0; i <= spans; ++i) breaks.push_back(static_cast<double>(i) / spans);
  return clamped(order - 1, breaks);
}

KnotVector with_gap(KnotVector knots, double at) {
  const auto equal = std::equal_range(knots.knots.begin(), knots.knots.end(), at);
  const auto more = knots.degree + 1 - (equal.second - equal.first);
  if (more > 0) knots.knots.insert(equal.second, static_cast<std::size_t>(more), at);
  return knots;
}

PublishedCurve published_curve(const std::vector<Vec3>& places, const std::vector<double>& parameters,
                               const KnotVector& knots) {
  ensure(places.size() == parameters.size() && places.size() >= 2, "a parameter for each of two or more places");
  PublishedCurve result;
  result.parameters = parameters;
  result.curve.t = knots;
  result.curve.points = BandedSystem(knots, parameters).solve(places);
  for (std::size_t i = 0; i < places.size(); ++i) {
    result.errors.push_back((result.curve.at(parameters[i]) - places[i]).norm());
    result.worst = std::max(result.worst, result.errors.back());
  }
  return result;
}

PublishedCurve refined_curve(const std::vector<Vec3>& places, const std::vector<double>& parameters,
                             const KnotVector& start, double tolerance) {
  KnotVector knots = start;
  PublishedCurve best = published_curve(places, parameters, knots);
  while (best.worst > tolerance) {
    bool more = false;
    for (const std::size_t i : local_maxima(best.errors, tolerance))
      more = insert_near(knots, parameters, parameters[i]) || more;
    if (!more || knots.count() > static_cast<int>(places.size())) break;
    best = published_curve(places, parameters, knots);
  }
  return best;
}

PublishedSurface published_surface(const PlaceGrid& grid, const KnotVector& u, const KnotVector& v, Parameters kind) {
  ensure(grid.columns >= 2 && grid.rows >= 2, "a grid has two columns and two rows at least");
  PublishedSurface result;
  const auto columns = static_cast<std::size_t>(grid.columns), rows = static_cast<std::size_t>(grid.rows);
  result.u.assign(columns, 0), result.v.assign(rows, 0);
  std::vector<Vec3> line;
  for (int r = 0; r < grid.rows; ++r) {
    line.clear();
    for (int c = 0; c < grid.columns; ++c) line.push_back(grid.at(c, r));
    const auto at = parameters_of(line, kind);
    for (std::size_t c = 0; c < columns; ++c) result.u[c] += at[c] / static_cast<double>(rows);
  }
  for (int c = 0; c < grid.columns; ++c) {
    line.clear();
    for (int r = 0; r < grid.rows; ++r) line.push_back(grid.at(c, r));
    const auto at = parameters_of(line, kind);
    for (std::size_t r = 0; r < rows; ++r) result.v[r] += at[r] / static_cast<double>(columns);
  }
  result.u.back() = result.v.back() = 1;
  const BandedSystem along_u(u, result.u), along_v(v, result.v);
  std::vector<std::vector<Vec3>> of_rows;
  for (int r = 0; r < grid.rows; ++r) {
    line.clear();
    for (int c = 0; c < grid.columns; ++c) line.push_back(grid.at(c, r));
    of_rows.push_back(along_u.solve(line));
  }
  result.surface.u = u, result.surface.v = v;
  for (int i = 0; i < u.count(); ++i) {
    line.clear();
    for (const auto& row : of_rows) line.push_back(row[std::size_t(i)]);
    const auto controls = along_v.solve(line);
    result.surface.points.insert(result.surface.points.end(), controls.begin(), controls.end());
  }
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t c = 0; c < columns; ++c) {
      const Vec3 off = result.surface.at(result.u[c], result.v[r]) - grid.at(int(c), int(r));
      result.errors.push_back(off.norm());
      result.worst = std::max(result.worst, result.errors.back());
    }
  return result;
}

PublishedSurface refined_surface(const PlaceGrid& grid, const KnotVector& u, const KnotVector& v, Parameters kind,
                                 double tolerance, int most_controls) {
  KnotVector along_u = u, along_v = v;
  PublishedSurface best = published_surface(grid, along_u, along_v, kind);
  const auto columns = static_cast<std::size_t>(grid.columns), rows = static_cast<std::size_t>(grid.rows);
  while (best.worst > tolerance) {
    // The largest errors of the columns and of the rows: a knot helps a whole strip.
    std::vector<double> of_columns(columns, 0), of_rows(rows, 0);
    for (std::size_t r = 0; r < rows; ++r)
      for (std::size_t c = 0; c < columns; ++c) {
        const double e = best.errors[r * columns + c];
        of_columns[c] = std::max(of_columns[c], e), of_rows[r] = std::max(of_rows[r], e);
      }
    bool more = false;
    for (const std::size_t c : local_maxima(of_columns, tolerance))
      more = insert_near(along_u, best.u, best.u[c]) || more;
    for (const std::size_t r : local_maxima(of_rows, tolerance)) more = insert_near(along_v, best.v, best.v[r]) || more;
    if (!more || along_u.count() * along_v.count() > most_controls) break;
    best = published_surface(grid, along_u, along_v, kind);
  }
  return best;
}

}  // namespace partscribe::fit
