#include "fit/surface/spline_fit.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "core/parallel.h"
#include "geometry/points/kd_tree.h"

namespace partscribe::fit {
namespace {

constexpr int degree = 3;
constexpr double fairness = 1e-6;  // of the bending energy, beside the mean squared distance

/// Which points have to be averaged with each other so that noise is a small part of the tolerance.
class Averages {
 public:
  Averages(const SplineData& data, const SplineFitOptions& options, Context& context)
      : size_(data.points.size() - data.held) {
    const double wanted = std::pow(options.noise / (0.12 * options.tolerance), 2);
    count_ = static_cast<std::size_t>(std::clamp(std::ceil(wanted), 6.0, 30.0));
    if (count_ == 1) return;
    std::vector<Vec3> flat;
    for (std::size_t i = 0; i < size_; ++i) flat.emplace_back(data.places[i].x(), data.places[i].y(), 0);
    const KdTree tree(flat);
    near_.resize(size_ * count_);
    parallel_for(size_, context.threads, [&](std::size_t begin, std::size_t end) {
      std::vector<Neighbour> found;
      for (std::size_t i = begin; i < end; ++i) {
        tree.nearest(flat[i], count_, found);
        for (std::size_t k = 0; k < count_; ++k) near_[i * count_ + k] = found[std::min(k, found.size() - 1)].index;
      }
    });
  }

  std::vector<double> operator()(const std::vector<double>& values) const {
    std::vector<double> result = values;
    for (std::size_t i = 0; i < size_; ++i) {
      double sum = 0;
      for (std::size_t k = 0; k < count_; ++k) sum += values[near_[i * count_ + k]];
      result[i] = sum / double(count_);
    }
    return result;
  }

 private:
  std::size_t size_, count_;
  std::vector<std::uint32_t> near_;
};

/// The least-squares net of given knots.
std::optional<NurbsSurface> fitted_net(const SplineData& data, const KnotVector& u, const KnotVector& v) {
  using Sparse = Eigen::SparseMatrix<double>;
  const int columns = v.count(), unknowns = u.count() * columns;
  constexpr int width = degree + 1;
  // Entries of the normal matrix by how far apart two control points are: (row, column) -> a block of 7 x 7 offsets.
  constexpr int reach = 2 * degree + 1;
  std::vector<double> blocks(std::size_t(unknowns) * reach * reach, 0.0);
  Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(unknowns, 3);
  const auto add = [&](const BasisValues& nu, const double* du, const BasisValues& nv, const double* dv, double weight,
                       const Vec3* target) {
    for (int i = 0; i < width; ++i)
      for (int j = 0; j < width; ++j) {
        const double a = weight * du[i] * dv[j];
        const int row = (nu.first + i) * columns + nv.first + j;
        if (target) right.row(row) += a * target->transpose();
        double* block = &blocks[std::size_t(row) * reach * reach];
        for (int k = 0; k < width; ++k)
          for (int l = 0; l < width; ++l) block[(k - i + degree) * reach + (l - j + degree)] += a * du[k] * dv[l];
      }
  };
  BasisValues nu, nv;
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    basis(u, data.places[i].x(), 0, nu);
    basis(v, data.places[i].y(), 0, nv);
    add(nu, nu.value[0], nv, nv.value[0], i < data.weights.size() ? data.weights[i] : 1, &data.points[i]);
  }
  // Bending energy at two by two Gauss points of each cell, in units of the cell.
  const auto us = u.breaks(), vs = v.breaks();
  const double cells = double(us.size() - 1) * double(vs.size() - 1);
  const double weight = fairness * double(data.points.size()) / cells / 4;
  for (std::size_t i = 0; i + 1 < us.size(); ++i)
    for (std::size_t j = 0; j + 1 < vs.size(); ++j) {
      const double hu = us[i + 1] - us[i], hv = vs[j + 1] - vs[j];
      for (const double a : {0.2113248654, 0.7886751346})
        for (const double b : {0.2113248654, 0.7886751346}) {
          basis(u, us[i] + a * hu, 2, nu);
          basis(v, vs[j] + b * hv, 2, nv);
          add(nu, nu.value[2], nv, nv.value[0], weight * std::pow(hu, 4), nullptr);
          add(nu, nu.value[0], nv, nv.value[2], weight * std::pow(hv, 4), nullptr);
          add(nu, nu.value[1], nv, nv.value[1], 2 * weight * hu * hu * hv * hv, nullptr);
        }
    }
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(blocks.size() / 2);
  for (int row = 0; row < unknowns; ++row)
    for (int k = 0; k < reach; ++k)
      for (int l = 0; l < reach; ++l) {
        const int column = row + (k - degree) * columns + l - degree;
        const double value = blocks[(std::size_t(row) * reach + std::size_t(k)) * reach + std::size_t(l)];
        if (value != 0 && column <= row) entries.emplace_back(row, column, value);
      }
  Sparse matrix(unknowns, unknowns);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Sparse, Eigen::Lower> factor(matrix);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const Eigen::MatrixX3d net = factor.solve(right);
  if (!net.allFinite()) return std::nullopt;
  NurbsSurface result{u, v, std::vector<Vec3>(std::size_t(unknowns)), {}};
  for (int i = 0; i < unknowns; ++i) result.points[std::size_t(i)] = net.row(i).transpose();
  return result;
}

/// Signed distances from a surface at the feet of the points, which are moved to where they are now.
struct Residuals {
  std::vector<double> single, mean;
  double worst = 0;
};

class Fitter {
 public:
  Fitter(const SplineData& data, const SplineFitOptions& options, Context& context)
      : data_(data), options_(options), context_(context), averages_(data, options, context) {}

  std::optional<SplineFit> fit() {
    KnotVector u = clamped(degree, {options_.low.x(), options_.high.x()});
    KnotVector v = clamped(degree, {options_.low.y(), options_.high.y()});
    if (!set(u, v, 3) || !refine()) return std::nullopt;
    remove_knots();
    return SplineFit{surface_, data_.places, now_.worst};
  }

  std::optional<SplineFit> fit_again(const NurbsSurface& before) {
    if (!set(before.u, before.v, 1) || !refine()) return std::nullopt;
    return SplineFit{surface_, data_.places, now_.worst};
  }

 private:
  /// Knots are inserted until the tolerance is kept.
  bool refine() {
    const double most = std::min(double(options_.most_controls), double(data_.points.size()) / 3);
    for (int round = 0; now_.worst > options_.tolerance; ++round) {
      context_.say("free form: " + std::to_string(surface_.u.count()) + " x " + std::to_string(surface_.v.count()) +
                   " control points, off by " + print_number(snapped(now_.worst, options_.tolerance / 1000)) + " mm");
      if (round == 40 || context_.cancelled) return false;
      auto [more_u, more_v] = refined();
      if (double(more_u.count()) * more_v.count() > most) return false;
      if (!set(more_u, more_v, 2)) return false;
    }
    return true;
  }

  /// Solves for a net with these knots and corrects the parameters, some times over.
  bool set(const KnotVector& u, const KnotVector& v, int rounds) {
    for (int i = 0; i < rounds; ++i) {
      auto next = fitted_net(data_, u, v);
      if (!next) return false;
      surface_ = std::move(*next);
      now_ = residuals();
    }
    return true;
  }

  /// Points are moved to their feet once the surface is close: before, feet run together where it bends too little.
  Residuals residuals() {
    Residuals r;
    r.single.resize(data_.points.size());
    std::vector<Vec2> feet(data_.places.size());
    parallel_for(data_.points.size(), context_.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const SplineFoot foot = foot_near(surface_, data_.points[i], data_.places[i].x(), data_.places[i].y());
        feet[i] = {foot.u, foot.v};
        const Vec3 normal = surface_.derivatives(foot.u, foot.v).normal();
        const double side = (data_.points[i] - foot.point).dot(normal);
        r.single[i] = std::copysign(foot.distance, side);
      }
    });
    r.mean = averages_(r.single);
    // Held points are compared with the same bound as the others.
    for (std::size_t i = r.mean.size() - data_.held; i < r.mean.size(); ++i)
      r.mean[i] *= options_.tolerance / options_.held_tolerance;
    for (const double d : r.mean) r.worst = std::max(r.worst, std::abs(d));
    if (r.worst < 4 * options_.tolerance) data_.places = std::move(feet);
    return r;
  }

  /// The knots with more of them in the middle of spans in which the tolerance is not kept.
  std::pair<KnotVector, KnotVector> refined() const {
    const auto us = surface_.u.breaks(), vs = surface_.v.breaks();
    const std::size_t columns = vs.size() - 1;
    struct Cell {
      double worst = 0;
      std::vector<std::size_t> points;
    };
    std::vector<Cell> cells((us.size() - 1) * columns);
    const auto span = [](const std::vector<double>& breaks, double t) {
      const auto at = std::upper_bound(breaks.begin() + 1, breaks.end() - 1, t) - breaks.begin();
      return static_cast<std::size_t>(at - 1);
    };
    for (std::size_t i = 0; i < data_.places.size(); ++i) {
      Cell& cell = cells[span(us, data_.places[i].x()) * columns + span(vs, data_.places[i].y())];
      cell.worst = std::max(cell.worst, std::abs(now_.mean[i]));
      cell.points.push_back(i);
    }
    std::vector<char> split_u(us.size() - 1, 0), split_v(columns, 0);
    for (std::size_t i = 0; i + 1 < us.size(); ++i)
      for (std::size_t j = 0; j < columns; ++j) {
        const Cell& cell = cells[i * columns + j];
        if (cell.worst <= options_.tolerance) continue;
        const auto [by_u, by_v] = variation(cell.points, {us[i], vs[j]}, {us[i + 1], vs[j + 1]});
        // Across the direction in which the residuals vary, or both; long spans first.
        const double most = std::max(by_u, by_v);
        const double long_u = us[i + 1] - us[i], long_v = vs[j + 1] - vs[j];
        if (by_u >= 0.5 * most && long_u > 0.3 * long_v) split_u[i] = 1;
        if (by_v >= 0.5 * most && long_v > 0.3 * long_u) split_v[j] = 1;
        if (!split_u[i] && !split_v[j]) (long_u > long_v ? split_u[i] : split_v[j]) = 1;
      }
    return {halved(us, split_u), halved(vs, split_v)};
  }

  static KnotVector halved(const std::vector<double>& breaks, const std::vector<char>& split) {
    std::vector<double> result = {breaks[0]};
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
      if (split[i]) result.push_back(0.5 * (breaks[i] + breaks[i + 1]));
      result.push_back(breaks[i + 1]);
    }
    return clamped(degree, result);
  }

  /// How much of the averaged residuals of a cell depends on u alone, and on v alone: variances of means of strips.
  std::pair<double, double> variation(const std::vector<std::size_t>& points, const Vec2& low, const Vec2& high) const {
    constexpr std::size_t strips = 6;
    double sum[2][strips] = {}, count[2][strips] = {}, mean = 0;
    for (const std::size_t i : points) {
      mean += now_.mean[i] / double(points.size());
      for (int axis = 0; axis < 2; ++axis) {
        const double share = (data_.places[i][axis] - low[axis]) / (high[axis] - low[axis]);
        const auto strip = static_cast<std::size_t>(std::clamp(share * double(strips), 0.0, double(strips) - 1));
        sum[axis][strip] += now_.mean[i], count[axis][strip] += 1;
      }
    }
    double result[2] = {};
    for (std::size_t axis = 0; axis < 2; ++axis)
      for (std::size_t s = 0; s < strips; ++s)
        if (count[axis][s] > 0) result[axis] += count[axis][s] * std::pow(sum[axis][s] / count[axis][s] - mean, 2);
    return {result[0], result[1]};
  }

  /// How far the third derivative jumps at a knot, in mm over the spans beside it.
  double jump(bool along_u, double before, double at, double after) const {
    const KnotVector& other = along_u ? surface_.v : surface_.u;
    const auto third = [&](double a, double b, double cross) {
      const double h = (b - a) / 4;
      const auto second = [&](double t) {
        const SurfacePoint p = along_u ? surface_.derivatives(t, cross) : surface_.derivatives(cross, t);
        return along_u ? p.duu : p.dvv;
      };
      return Vec3((second(b - h) - second(a + h)) / (2 * h));
    };
    double most = 0;
    for (int k = 0; k <= 12; ++k) {
      const double cross = other.low() + (other.high() - other.low()) * k / 12;
      const Vec3 step = third(at, after, cross) - third(before, at, cross);
      most = std::max(most, step.norm());
    }
    return most * std::pow(std::min(at - before, after - at), 3);
  }

  void remove_knots() {
    struct Knot {
      bool along_u;
      double at, jump;
    };
    for (int rounds = 0; rounds < 3; ++rounds) {
      std::vector<Knot> knots;
      for (const bool along_u : {true, false}) {
        const auto breaks = (along_u ? surface_.u : surface_.v).breaks();
        for (std::size_t i = 1; i + 1 < breaks.size(); ++i)
          knots.push_back({along_u, breaks[i], jump(along_u, breaks[i - 1], breaks[i], breaks[i + 1])});
      }
      std::stable_sort(knots.begin(), knots.end(), [](const Knot& a, const Knot& b) { return a.jump < b.jump; });
      int removed = 0, refused = 0;
      for (const Knot& knot : knots) {
        if (refused == 6 || context_.cancelled) break;
        const auto surface = surface_;
        const auto places = data_.places;
        const auto now = now_;
        KnotVector u = surface_.u, v = surface_.v;
        auto& list = (knot.along_u ? u : v).knots;
        list.erase(std::find(list.begin(), list.end(), knot.at));
        if (set(u, v, 2) && now_.worst <= options_.tolerance) {
          ++removed;
          continue;
        }
        surface_ = surface, data_.places = places, now_ = now;
        ++refused;
      }
      if (removed == 0) break;
    }
  }

  SplineData data_;  // its places are moved to the feet
  const SplineFitOptions& options_;
  Context& context_;
  Averages averages_;
  NurbsSurface surface_;
  Residuals now_;
};

}  // namespace

std::optional<SplineFit> fit_spline(const SplineData& data, const SplineFitOptions& options, Context& context) {
  if (data.points.size() < 16) return std::nullopt;
  return Fitter(data, options, context).fit();
}

std::optional<SplineFit> fit_spline_again(const SplineData& data, const NurbsSurface& before,
                                          const SplineFitOptions& options, Context& context) {
  return Fitter(data, options, context).fit_again(before);
}

}  // namespace partscribe::fit
