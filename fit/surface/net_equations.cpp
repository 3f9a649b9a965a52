#include "fit/surface/net_equations.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/surfaces/cubic_basis.h"

namespace partscribe::fit {
namespace {

/// Symmetric, banded: row i holds the entries i - 3 .. i + 3.
using Band = std::vector<double>;

/// Gram matrices of the derivatives of one direction, at two Gauss points of each cell, in units of the cell.
std::array<Band, 3> bending_of(const KnotVector& knots) {
  std::array<Band, 3> result;
  for (auto& m : result) m.assign(std::size_t(knots.count()) * 7, 0.0);
  const auto breaks = knots.breaks();
  BasisValues n;
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    const double h = breaks[i + 1] - breaks[i];
    for (const double a : {0.2113248654, 0.7886751346}) {
      basis(knots, breaks[i] + a * h, 2, n);
      for (int d = 0; d < 3; ++d)
        for (int k = 0; k < 4; ++k)
          for (int l = 0; l < 4; ++l)
            result[std::size_t(d)][std::size_t(n.first + k) * 7 + std::size_t(l - k + 3)] +=
                std::pow(h, 2 * d) * n.value[d][k] * n.value[d][l];
    }
  }
  return result;
}

/// Adds R^T M R to `result`, of a band whose entries are numbers.
void restrict_numbers(const double* fine, const Restriction& r, double* result) {
  const int count = int(r.first.size());
  for (int p = 0; p < count; ++p) {
    // Row p of M R lies in the columns from `from` on, as columns go up by one at most from row to row.
    const int from = r.first[std::size_t(p)] - 3;
    double line[10] = {};
    for (int q = std::max(p - 3, 0); q <= std::min(p + 3, count - 1); ++q) {
      const double entry = fine[p * 7 + q - p + 3];
      const double* share = &r.share[std::size_t(q) * 4];
      double* to = line + (r.first[std::size_t(q)] - from);
      for (int k = 0; k < 4; ++k) to[k] += share[k] * entry;
    }
    for (int k = 0; k < 4; ++k) {
      const double share = r.share[std::size_t(p) * 4 + std::size_t(k)];
      double* to = result + (r.first[std::size_t(p)] + k) * 7;
      for (int d = 0; d < 7; ++d) to[d] += share * line[k + d];
    }
  }
}

/// The same where an entry is `size` numbers.
void restrict_blocks(const double* fine, const Restriction& r, std::size_t size, double* result) {
  std::vector<double> line(10 * size);
  const int count = int(r.first.size());
  const auto add = [&](double share, const double* from, double* to) {
    for (std::size_t s = 0; s < size; ++s) to[s] += share * from[s];
  };
  for (int p = 0; p < count; ++p) {
    const int from = r.first[std::size_t(p)] - 3;
    std::fill(line.begin(), line.end(), 0.0);
    for (int q = std::max(p - 3, 0); q <= std::min(p + 3, count - 1); ++q)
      for (std::size_t k = 0; k < 4; ++k)
        if (const double share = r.share[std::size_t(q) * 4 + k]; share != 0)
          add(share, fine + std::size_t(p * 7 + q - p + 3) * size,
              &line[(std::size_t(r.first[std::size_t(q)] - from) + k) * size]);
    for (std::size_t k = 0; k < 4; ++k)
      if (const double share = r.share[std::size_t(p) * 4 + k]; share != 0)
        for (std::size_t d = 0; d < 7; ++d)
          add(share, &line[(k + d) * size], result + ((std::size_t(r.first[std::size_t(p)]) + k) * 7 + d) * size);
  }
}

}  // namespace

Restriction restriction(const KnotVector& fine, const KnotVector& coarse) {
  Restriction result;
  result.coarse = coarse.count();
  for (int p = 0; p < fine.count(); ++p) {
    const int span = coarse.span(fine.knots[std::size_t(p)]);
    double n[4] = {1, 0, 0, 0};
    // As basis(), with another place at each degree.
    for (int j = 1; j <= 3; ++j) {
      const double t = fine.knots[std::size_t(p + j)];
      double saved = 0;
      for (int r = 0; r < j; ++r) {
        const double right = coarse.knots[std::size_t(span + r + 1)],
                     left = coarse.knots[std::size_t(span + 1 - j + r)];
        const double share = n[r] / (right - left);
        n[r] = saved + (right - t) * share;
        saved = (t - left) * share;
      }
      n[j] = saved;
    }
    // At a multiple knot the last functions that begin there have no share in the first of the fine ones.
    const double at = fine.knots[std::size_t(p)];
    int spare = 0;
    while (at > fine.low() && spare < 3 && fine.knots[std::size_t(p + spare + 1)] == at &&
           coarse.knots[std::size_t(span - spare)] == at)
      ++spare;
    result.first.push_back(span - 3 - spare);
    result.share.insert(result.share.end(), std::size_t(spare), 0.0);
    result.share.insert(result.share.end(), n, n + 4 - spare);
  }
  return result;
}

NetEquations::NetEquations(KnotVector u, KnotVector v)
    : u_(std::move(u)), v_(std::move(v)), a_(rows() * reach * reach, 0.0), b_(rows(), Vec3::Zero()) {}

void NetEquations::add(std::span<const Vec3> points, std::span<const Vec2> places, std::span<const double> weights) {
  // Points in turn that lie in one cell are summed before they are spread.
  Eigen::Matrix<double, 16, 16> gram = Eigen::Matrix<double, 16, 16>::Zero();
  Eigen::Matrix<double, 16, 3> right = Eigen::Matrix<double, 16, 3>::Zero();
  int at_u = -1, at_v = -1;
  const int columns = v_.count();
  const auto spread = [&] {
    if (at_u < 0) return;
    for (int i = 0; i < width; ++i)
      for (int j = 0; j < width; ++j) {
        const std::size_t row = std::size_t((at_u + i) * columns + at_v + j);
        b_[row] += right.row(i * width + j).transpose();
        double* block = &a_[row * reach * reach];
        for (int k = 0; k < width; ++k)
          for (int l = 0; l < width; ++l)
            block[(k - i + degree) * reach + (l - j + degree)] += gram(k * width + l, i * width + j);
      }
    gram.setZero(), right.setZero();
  };
  CubicBasis nu(u_), nv(v_);
  Eigen::Matrix<double, 16, 1> n;
  for (std::size_t p = 0; p < points.size(); ++p) {
    nu.move_to(places[p].x()), nv.move_to(places[p].y());
    if (nu.first != at_u || nv.first != at_v) spread(), at_u = nu.first, at_v = nv.first;
    const double weight = weights.empty() ? 1 : weights[p];
    for (int i = 0; i < width; ++i)
      for (int j = 0; j < width; ++j) n[i * width + j] = nu.value[i] * nv.value[j];
    gram.noalias() += (weight * n) * n.transpose();
    right.noalias() += (weight * n) * points[p].transpose();
    weight_ += weight;
  }
  spread();
}

const NetEquations::Half& NetEquations::half(bool along_u, const KnotVector& knots) const {
  Half& result = along_u ? half_u_ : half_v_;
  if (result.knots == knots) return result;
  const Restriction r = restriction(along_u ? u_ : v_, knots);
  const std::size_t lines = std::size_t((along_u ? v_ : u_).count()), across = r.first.size();
  const std::size_t coarse = std::size_t(r.coarse);
  result.knots = knots;
  result.entries.assign(lines * reach * coarse * reach, 0.0);
  Band line(across * reach);
  for (std::size_t p = 0; p < lines; ++p)
    for (std::size_t d = 0; d < reach; ++d) {
      for (std::size_t q = 0; q < across; ++q) {
        const std::size_t row = along_u ? q * lines + p : p * across + q;
        for (std::size_t e = 0; e < reach; ++e)
          line[q * reach + e] = a_[row * reach * reach + (along_u ? e * reach + d : d * reach + e)];
      }
      restrict_numbers(line.data(), r, &result.entries[(p * reach + d) * coarse * reach]);
    }
  return result;
}

std::vector<double> NetEquations::restricted_both(const KnotVector& u, const KnotVector& v) const {
  const bool same_u = half_u_.knots == u, same_v = half_v_.knots == v;
  const bool first_u = same_u || (!same_v && u == last_u_);
  last_u_ = u;
  const Half& one = first_u ? half(true, u) : half(false, v);
  const Restriction r = first_u ? restriction(v_, v) : restriction(u_, u);
  const std::size_t rows = std::size_t(u.count()), columns = std::size_t(v.count());
  const std::size_t size = (first_u ? rows : columns) * reach;
  Band result(rows * columns * reach * reach, 0.0);
  if (!first_u) {
    restrict_blocks(one.entries.data(), r, size, result.data());
    return result;
  }
  Band turned(result.size(), 0.0);  // [j][l - j][i][k - i]
  restrict_blocks(one.entries.data(), r, size, turned.data());
  for (std::size_t j = 0; j < columns; ++j)
    for (std::size_t l = 0; l < reach; ++l)
      for (std::size_t i = 0; i < rows; ++i)
        for (std::size_t k = 0; k < reach; ++k)
          result[((i * reach + k) * columns + j) * reach + l] = turned[((j * reach + l) * rows + i) * reach + k];
  return result;
}

std::optional<NurbsSurface> NetEquations::solve(const KnotVector& u, const KnotVector& v, double fairness) const {
  const Restriction ru = restriction(u_, u), rv = restriction(v_, v);
  const std::size_t fine_rows = std::size_t(u_.count()), fine_columns = std::size_t(v_.count());
  const std::size_t rows = std::size_t(u.count()), columns = std::size_t(v.count());
  const Band matrix = restricted_both(u, v);  // [i][k - i][j][l - j]
  const double cells = double(u.breaks().size() - 1) * double(v.breaks().size() - 1);
  const double weight = fairness * weight_ / cells / 4;
  const auto bu = bending_of(u), bv = bending_of(v);
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(rows * columns * 25);
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t k = 0; k <= degree; ++k) {
      const int other = int(i) + int(k) - degree;  // rows up to i: the lower half
      if (other < 0) continue;
      const double u0 = bu[0][i * 7 + k], u1 = bu[1][i * 7 + k], u2 = bu[2][i * 7 + k];
      for (std::size_t j = 0; j < columns; ++j)
        for (std::size_t l = 0; l < reach; ++l) {
          const int column = int(j) + int(l) - degree;
          if (column < 0 || column >= int(columns)) continue;
          const int from = int(i * columns + j), to = other * int(columns) + column;
          if (to > from) continue;
          double value = matrix[((i * reach + k) * columns + j) * reach + l];
          value += weight * (u2 * bv[0][j * 7 + l] + 2 * u1 * bv[1][j * 7 + l] + u0 * bv[2][j * 7 + l]);
          entries.emplace_back(from, to, value);
        }
    }
  const int unknowns = int(rows * columns);
  Eigen::SparseMatrix<double> lower(unknowns, unknowns);
  lower.setFromTriplets(entries.begin(), entries.end());
  Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(unknowns, 3);
  for (std::size_t p = 0; p < fine_rows; ++p)
    for (std::size_t q = 0; q < fine_columns; ++q)
      for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t l = 0; l < 4; ++l) {
          const double share = ru.share[p * 4 + k] * rv.share[q * 4 + l];
          if (share != 0)
            right.row((ru.first[p] + int(k)) * int(columns) + rv.first[q] + int(l)) +=
                share * b_[p * fine_columns + q].transpose();
        }
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> factor(lower);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const Eigen::MatrixX3d net = factor.solve(right);
  if (!net.allFinite()) return std::nullopt;
  NurbsSurface result{u, v, std::vector<Vec3>(std::size_t(unknowns)), {}};
  for (int i = 0; i < unknowns; ++i) result.points[std::size_t(i)] = net.row(i).transpose();
  return result;
}

double NetEquations::explained(const NurbsSurface& surface) const {
  double result = 0;
  for (std::size_t i = 0; i < b_.size(); ++i) result += b_[i].dot(surface.points[i]);
  return result;
}

NetEquations::Left NetEquations::left(const NurbsSurface& surface) const {
  const Restriction ru = restriction(u_, surface.u), rv = restriction(v_, surface.v);
  const std::size_t rows = ru.first.size(), columns = rv.first.size(), coarse = std::size_t(rv.coarse);
  std::vector<Vec3> lines(std::size_t(ru.coarse) * columns, Vec3::Zero()), net(rows * columns, Vec3::Zero());
  for (std::size_t i = 0; i < std::size_t(ru.coarse); ++i)
    for (std::size_t q = 0; q < columns; ++q)
      for (std::size_t l = 0; l < 4; ++l)
        lines[i * columns + q] += rv.share[q * 4 + l] * surface.points[i * coarse + std::size_t(rv.first[q]) + l];
  for (std::size_t p = 0; p < rows; ++p)
    for (std::size_t k = 0; k < 4; ++k) {
      const double share = ru.share[p * 4 + k];
      const Vec3* from = &lines[(std::size_t(ru.first[p]) + k) * columns];
      for (std::size_t q = 0; q < columns; ++q) net[p * columns + q] += share * from[q];
    }
  Left result;
  result.mean.assign(rows * columns, 0.0), result.points.assign(rows * columns, 0.0);
  for (std::size_t p = 0; p < rows; ++p)
    for (std::size_t q = 0; q < columns; ++q) {
      const std::size_t at = p * columns + q;
      const double* block = &a_[at * reach * reach];
      double all = 0;
      Vec3 sum = b_[at];
      const std::size_t from = q < degree ? degree - q : 0, to = std::min<std::size_t>(reach, columns - q + degree);
      for (std::size_t k = p < degree ? degree - p : 0; k < reach && p + k - degree < rows; ++k) {
        const Vec3* line = &net[(p + k - degree) * columns];
        for (std::size_t l = from; l < to; ++l) {
          const double entry = block[k * reach + l];
          all += entry, sum -= entry * line[q + l - degree];
        }
      }
      const double own = block[degree * reach + degree];
      if (!(own > 0)) continue;
      const std::size_t u0 = (p ? p - 1 : p) * columns + q, u1 = (p + 1 < rows ? p + 1 : p) * columns + q;
      const std::size_t v0 = q ? at - 1 : at, v1 = q + 1 < columns ? at + 1 : at;
      const Vec3 normal = (net[u1] - net[u0]).cross(net[v1] - net[v0]).normalized();
      result.mean[at] = sum.dot(normal) / all;
      result.points[at] = all * all / own;
    }
  return result;
}

}  // namespace partscribe::fit
