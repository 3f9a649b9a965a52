#include "geometry/surfaces/nurbs_nearest.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "core/ensure.h"
#include "geometry/surfaces/nurbs_edit.h"

namespace partscribe::geometry {
namespace {

/// Squared distance over a rectangle of parameters: above / below, both in the Bernstein basis.
struct DistanceCell {
  double u0, u1, v0, v1;
  Eigen::MatrixXd above, below;  // rows run along u
  double sq_low = 0;             // no place is nearer
  int place_u = 0, place_v = 0;  // of the least control value
  int number = 0;                // the order in which cells were made
};

/// The nearest comes first; of equals the older.
struct FartherCell {
  bool operator()(const DistanceCell& a, const DistanceCell& b) const {
    return a.sq_low != b.sq_low ? a.sq_low > b.sq_low : a.number > b.number;
  }
};

std::vector<double> binomials(int n) {
  std::vector<double> row(std::size_t(n) + 1, 1.0);
  for (int k = 1; k <= n; ++k) row[std::size_t(k)] = row[std::size_t(k) - 1] * (n - k + 1) / k;
  return row;
}

void bound_cell(DistanceCell& cell) {
  cell.sq_low = (cell.above.array() / cell.below.array()).minCoeff(&cell.place_u, &cell.place_v);
}

DistanceCell cell_of(const NurbsSurface& piece, const Vec3& p) {
  const int n = piece.u.degree, m = piece.v.degree;
  DistanceCell cell{piece.u.low(), piece.u.high(), piece.v.low(), piece.v.high(), {}, {}};
  cell.above.setZero(2 * n + 1, 2 * m + 1), cell.below.setZero(2 * n + 1, 2 * m + 1);
  const auto bn = binomials(n), bm = binomials(m), bnn = binomials(2 * n), bmm = binomials(2 * m);
  std::vector<Eigen::Vector4d> scaled;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= m; ++j) {
      const std::size_t c = std::size_t(i * (m + 1) + j);
      const double w = (piece.weights.empty() ? 1 : piece.weights[c]) * bn[std::size_t(i)] * bm[std::size_t(j)];
      const Vec3 off = w * (piece.points[c] - p);
      scaled.emplace_back(off.x(), off.y(), off.z(), w);
    }
  for (std::size_t a = 0; a < scaled.size(); ++a)
    for (std::size_t b = 0; b < scaled.size(); ++b) {
      const Eigen::Index k = Eigen::Index(a) / (m + 1) + Eigen::Index(b) / (m + 1);
      const Eigen::Index l = Eigen::Index(a) % (m + 1) + Eigen::Index(b) % (m + 1);
      cell.above(k, l) += scaled[a].head<3>().dot(scaled[b].head<3>());
      cell.below(k, l) += scaled[a].w() * scaled[b].w();
    }
  for (int k = 0; k <= 2 * n; ++k)
    for (int l = 0; l <= 2 * m; ++l) {
      const double f = 1 / (bnn[std::size_t(k)] * bmm[std::size_t(l)]);
      cell.above(k, l) *= f, cell.below(k, l) *= f;
    }
  bound_cell(cell);
  return cell;
}

/// The control values of both halves (de Casteljau).
void halve_rows(const Eigen::MatrixXd& whole, Eigen::MatrixXd& first, Eigen::MatrixXd& second) {
  const Eigen::Index last = whole.rows() - 1;
  first = second = whole;
  for (Eigen::Index r = 0; r <= last; ++r) {
    first.row(r) = second.row(0);
    for (Eigen::Index i = 0; i < last - r; ++i) second.row(i) = 0.5 * (second.row(i) + second.row(i + 1)).eval();
  }
}

void halve_cell(const DistanceCell& cell, bool along_u, DistanceCell& first, DistanceCell& second) {
  first.u0 = second.u0 = cell.u0, first.u1 = second.u1 = cell.u1;
  first.v0 = second.v0 = cell.v0, first.v1 = second.v1 = cell.v1;
  (along_u ? first.u1 : first.v1) = (along_u ? second.u0 : second.v0) =
      along_u ? 0.5 * (cell.u0 + cell.u1) : 0.5 * (cell.v0 + cell.v1);
  for (auto values : {&DistanceCell::above, &DistanceCell::below}) {
    if (along_u) {
      halve_rows(cell.*values, first.*values, second.*values);
    } else {
      Eigen::MatrixXd a, b;
      halve_rows((cell.*values).transpose(), a, b);
      first.*values = a.transpose(), second.*values = b.transpose();
    }
  }
  bound_cell(first), bound_cell(second);
}

double roughness(const Eigen::MatrixXd& values, bool along_u) {
  const Eigen::Index rows = values.rows(), cols = values.cols();
  if (along_u) return rows < 2 ? -1 : (values.bottomRows(rows - 1) - values.topRows(rows - 1)).cwiseAbs().maxCoeff();
  return cols < 2 ? -1 : (values.rightCols(cols - 1) - values.leftCols(cols - 1)).cwiseAbs().maxCoeff();
}

/// `local(u, v)`: the foot near a start, at most as far as the start.
template <class Local>
SplineFoot nearest_cell(const NurbsSurface& surface, const Vec3& p, double tolerance, const Local& local) {
  ensure(tolerance > 0, "the nearest place is found within a tolerance");
  const double least_u = 1e-13 * (surface.u.high() - surface.u.low());
  const double least_v = 1e-13 * (surface.v.high() - surface.v.low());
  SplineFoot best;
  best.distance = std::numeric_limits<double>::infinity();
  const auto look = [&](const DistanceCell& cell) {
    const double du = cell.above.rows() > 1 ? double(cell.place_u) / double(cell.above.rows() - 1) : 0;
    const double dv = cell.above.cols() > 1 ? double(cell.place_v) / double(cell.above.cols() - 1) : 0;
    const double u = cell.u0 + du * (cell.u1 - cell.u0), v = cell.v0 + dv * (cell.v1 - cell.v0);
    if (!((surface.at(u, v) - p).norm() < best.distance)) return;
    const SplineFoot foot = local(u, v);
    if (foot.distance < best.distance) best = foot;
  };
  std::priority_queue<DistanceCell, std::vector<DistanceCell>, FartherCell> cells;
  int number = 0;
  for (const NurbsSurface& piece : bezier_pieces(surface)) {
    cells.push(cell_of(piece, p));
    ++number;
  }
  while (!cells.empty()) {
    const DistanceCell cell = cells.top();
    if (std::sqrt(std::max(cell.sq_low, 0.0)) >= best.distance - tolerance) break;
    cells.pop();
    look(cell);
    const bool along_u = roughness(cell.above, true) >= roughness(cell.above, false);
    if (cell.u1 - cell.u0 < least_u || cell.v1 - cell.v0 < least_v) continue;
    DistanceCell halves[2];
    halve_cell(cell, along_u, halves[0], halves[1]);
    for (DistanceCell& half : halves) {
      half.number = ++number;
      if (std::sqrt(std::max(half.sq_low, 0.0)) < best.distance - tolerance) cells.push(std::move(half));
    }
  }
  return best;
}

}  // namespace

SplineFoot foot_near(const NurbsCurve<3>& curve, const Vec3& p, double u) {
  const double low = curve.t.low(), high = curve.t.high();
  u = std::clamp(u, low, high);
  Vec3 at, first, second;
  curve.derivatives(u, at, first, second);
  double best = (at - p).squaredNorm();
  for (int round = 0; round < 30; ++round) {
    const double g = first.dot(at - p), full = first.squaredNorm() + second.dot(at - p);
    const double slope = full > 1e-3 * first.squaredNorm() ? full : first.squaredNorm();
    if (!(slope > 0)) break;
    bool nearer = false;
    for (double step = 1; step > 1e-3 && !nearer; step /= 4) {
      const double next = std::clamp(u - step * g / slope, low, high);
      const double d = (curve.at(next) - p).squaredNorm();
      if (!(d < best)) continue;
      nearer = true;
      const bool settled = best - d < 1e-14 * best;
      u = next, best = d;
      curve.derivatives(u, at, first, second);
      if (settled) return {u, 0, std::sqrt(best), at};
    }
    if (!nearer) break;
  }
  return {u, 0, std::sqrt(best), at};
}

SplineFoot nearest_on(const NurbsCurve<3>& curve, const Vec3& p, double tolerance) {
  return nearest_cell(as_surface(curve), p, tolerance, [&](double u, double) { return foot_near(curve, p, u); });
}

SplineFoot nearest_on(const NurbsSurface& surface, const Vec3& p, double tolerance) {
  return nearest_cell(surface, p, tolerance, [&](double u, double v) { return foot_near(surface, p, u, v); });
}

}  // namespace partscribe::geometry
