#include "geometry/surfaces/primitive_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/ensure.h"
#include "core/number.h"
#include "core/random.h"
#include "core/statistics.h"
#include "geometry/decompose.h"
#include "geometry/surfaces/primitive_kernels.h"
#include "geometry/surfaces/primitive_start.h"

namespace partscribe::geometry {
namespace {

using Unknowns = Eigen::Matrix<double, max_unknowns, 1>;

constexpr std::size_t enough_to_start = 512;  // points that choose the basin; all points then settle the digits
constexpr double loosest_axis = 0.2;          // rad, 1 sigma: beyond it a direction is not known
constexpr double loosest_size = 1.0 / 3;      // sigma over size: below three sigma a size may as well be infinite

// ---------------------------------------------------------------- one step in a chart

/// The chart moved by a step. Where the points go far around the surface the radius is the better coordinate, where
/// they are nearly flat the curvature is; both agree to first order, and so do the derivatives.
PrimitiveChart moved(const PrimitiveChart& chart, const Unknowns& step, bool wide) {
  PrimitiveChart next = chart;
  Vec3 shift = Vec3::Zero(), turn = Vec3::Zero();
  const double radius = wide ? 1 / chart.kappa : 0;
  const auto bend = [&](double change) {
    if (wide)
      next.kappa = 1 / std::max(radius - change * radius * radius, 0.2 * radius);
    else
      next.kappa += change;
  };
  switch (chart.kind) {
    case ChartKind::sphere:
      bend(step[3]);
      shift = wide ? Vec3(step[0], -radius * step[1], -radius * step[2]) : Vec3(step[0], 0, 0);
      if (!wide) turn = Vec3(0, -step[2], step[1]);
      break;
    case ChartKind::cylinder:
    case ChartKind::circle:
    case ChartKind::cone: {
      bend(step[4]);
      shift = Vec3(step[0], wide ? -radius * step[1] : 0, chart.kind == ChartKind::circle ? step[5] : 0);
      if (chart.kind == ChartKind::cone) {
        shift.z() = -std::sin(chart.psi) * step[0];
        shift.x() = std::cos(chart.psi) * step[0];
        next.psi = std::clamp(chart.psi + step[5], -1.56, 1.56);
      }
      turn = Vec3(step[2], step[3], wide ? 0 : step[1]);
      break;
    }
    case ChartKind::torus:
      shift = step.head<3>();
      turn = Vec3(step[3], step[4], 0);
      next.ring = std::abs(chart.ring + step[5]);  // the mirror image of a negative ring is the same surface
      next.tube = std::max(chart.tube + step[6], 0.2 * chart.tube);
      break;
  }
  next.origin += chart.frame.transpose() * shift;
  next.frame = rotation_of(turn).transpose() * chart.frame;
  return recentered(next);
}

/// Largest turn of a step, rad; what is bounded, because the distance is far from linear in it.
double turn_of(ChartKind kind, const Unknowns& step) {
  switch (kind) {
    case ChartKind::sphere:
      return 0;
    case ChartKind::cylinder:
    case ChartKind::circle:
      return std::hypot(step[2], step[3]);
    case ChartKind::cone:
      return std::max(std::hypot(step[2], step[3]), std::abs(step[5]));
    case ChartKind::torus:
      return std::hypot(step[3], step[4]);
  }
  return 0;
}

/// Do the points span so much of the circle that its radius is as good a coordinate as its curvature?
bool is_wide(const PrimitiveChart& chart, const KernelEquations& sums) {
  if (chart.kind == ChartKind::torus || chart.kappa <= 0) return false;
  double across = sums.H(1, 1);
  if (chart.kind == ChartKind::sphere) across = std::max(across, sums.H(2, 2));
  return chart.kappa * std::sqrt(across / std::max(sums.weight, 1e-300)) > 0.15;
}

struct Minimum {
  PrimitiveChart chart;
  KernelEquations sums;
  bool converged = false;
};

/// Levenberg-Marquardt from `chart`. Ends when a step would change the distances by less than `precision` of their
/// rms, or when they are exact.
Minimum minimized(const ScaledPoints& points, const PrimitiveChart& start, double reach, int most_steps,
                  double precision, double lambda) {
  Minimum best{recentered(start), {}, false};
  best.sums = normal_equations(points, best.chart, reach);
  const int m = unknowns_of(start.kind);
  double previous = 0;
  for (int step_count = 0; step_count < most_steps; ++step_count) {
    const KernelEquations& sums = best.sums;
    if (!std::isfinite(sums.cost) || !(sums.weight > 0)) return best;
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_unknowns, max_unknowns> scaled(m, m);
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_unknowns, 1> scale(m);
    const double largest = sums.H.diagonal().head(m).maxCoeff();
    for (int i = 0; i < m; ++i) scale[i] = sums.H(i, i) > 1e-30 * largest ? 1 / std::sqrt(sums.H(i, i)) : 0;
    scaled = scale.asDiagonal() * sums.H.topLeftCorner(m, m) * scale.asDiagonal();
    scaled.diagonal().array() += lambda + 1e-15;
    Unknowns step = Unknowns::Zero();
    step.head(m) = -(scale.asDiagonal() * scaled.ldlt().solve(scale.asDiagonal() * sums.g.head(m)));
    if (!step.allFinite()) return best;
    const double turn = turn_of(start.kind, step);
    if (turn > 0.5) step *= 0.5 / turn;

    const double change = std::sqrt(std::max(step.dot(sums.H * step), 0.0) / sums.weight);
    const double rms = std::sqrt(sums.squares / sums.weight);
    PrimitiveChart next = moved(best.chart, step, is_wide(best.chart, sums));
    // Steps shrink by a constant factor near the end, so the one after this is known before it is paid for.
    const bool shrinking = lambda == 0 && previous > 0 && change < 0.01 * previous;
    const double following = shrinking ? change * (change / previous) : change;
    if (following <= precision * rms || change < 1e-14) {
      best.chart = next;  // too small to be worth another pass; the sums stay those of the place before
      best.converged = true;
      return best;
    }
    KernelEquations there = normal_equations(points, next, reach);
    if (there.cost < sums.cost) {
      best.chart = next;
      best.sums = there;
      previous = change;
      lambda = lambda > 1e-9 ? lambda * 0.1 : 0;
    } else if (change < 1e-6 * rms || change < 1e-12) {
      best.converged = true;  // rounding decides which side is lower
      return best;
    } else {
      lambda = lambda > 0 ? lambda * 10 : 1e-4;
      if (lambda > 1e8) return best;
    }
  }
  return best;
}

// ---------------------------------------------------------------- primitives and charts

ChartKind chart_kind(PrimitiveKind kind) {
  switch (kind) {
    case PrimitiveKind::circle:
      return ChartKind::circle;
    case PrimitiveKind::cylinder:
      return ChartKind::cylinder;
    case PrimitiveKind::cone:
      return ChartKind::cone;
    case PrimitiveKind::torus:
      return ChartKind::torus;
    default:
      return ChartKind::sphere;
  }
}

/// Where the points are: subtracted first, so that far from the origin nothing is lost.
struct Place {
  Vec3 center = Vec3::Zero();
  double factor = 1;  ///< a power of two: exact
};

PrimitiveChart chart_of(const Primitive& primitive, const Place& place) {
  const Vec3 point = (primitive.point - place.center) * place.factor;
  const Vec3 axis = primitive.axis.normalized();
  const double radius = std::max(primitive.radius * place.factor, 1e-9);
  const ChartKind kind = chart_kind(primitive.kind);
  if (kind == ChartKind::torus) {
    PrimitiveChart chart;
    chart.kind = kind;
    chart.origin = point;
    chart.frame = rotation_onto_axis(axis).transpose();
    chart.ring = primitive.radius * place.factor;
    chart.tube = primitive.tube * place.factor;
    return chart;
  }
  if (kind == ChartKind::sphere) {
    const Vec3 n = point.norm() > 1e-6 ? Vec3(-point.normalized()) : Vec3(Vec3::UnitX());
    return surface_chart(kind, point + radius * n, n, n.unitOrthogonal(), 1 / radius, 0);
  }
  Vec3 center = point;
  double here = radius;
  if (kind == ChartKind::cone) {  // a chart stands clear of the apex
    const double height = -point.dot(axis);
    here = std::max(radius + height * std::tan(primitive.half_angle), 0.05);
    center += axis * height;
  }
  Vec3 n = axis * axis.dot(center) - center;
  n = n.norm() > 1e-6 ? n.normalized() : axis.unitOrthogonal();
  return surface_chart(kind, center + here * n, n, axis, 1 / here, kind == ChartKind::cone ? primitive.half_angle : 0);
}

/// An axis without a sense of its own gets one that small changes do not flip.
Vec3 oriented(const Vec3& axis) {
  int largest = 2;
  for (int i = 1; i >= 0; --i)
    if (std::abs(axis[i]) > 1.1 * std::abs(axis[largest])) largest = i;
  return axis[largest] < 0 ? Vec3(-axis) : axis;
}

double largest_sigma(const Eigen::MatrixXd& rows, const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd c = rows * covariance * rows.transpose();
  return std::sqrt(std::max(eigenvalues_of(c).maxCoeff(), 0.0));
}

/// The inverse of H; directions that the points say nothing about get a huge variance instead of an infinite one.
Eigen::MatrixXd inverse_of(const KernelEquations& sums, int m, bool& full_rank) {
  Eigen::VectorXd scale(m);
  for (int i = 0; i < m; ++i) scale[i] = sums.H(i, i) > 0 ? 1 / std::sqrt(sums.H(i, i)) : 1;
  const Eigen::MatrixXd scaled = scale.asDiagonal() * sums.H.topLeftCorner(m, m) * scale.asDiagonal();
  const auto solver = eigensystem(scaled);
  Eigen::VectorXd inverse(m);
  for (int i = 0; i < m; ++i) {
    const double value = solver.values[i];
    if (!(value > 1e-13)) full_rank = false;
    inverse[i] = 1 / std::max(value, 1e-13);
  }
  return scale.asDiagonal() * solver.vectors * inverse.asDiagonal() * solver.vectors.transpose() * scale.asDiagonal();
}

/// Numbers and their deviations from a chart at its minimum; `variance` is that of one distance in the chart's units.
PrimitiveFit fit_of(PrimitiveKind kind, const Minimum& minimum, double variance, const Place& place) {
  const PrimitiveChart& chart = minimum.chart;
  const int m = unknowns_of(chart.kind);
  PrimitiveFit fit;
  fit.primitive.kind = kind;
  fit.converged = minimum.converged;
  bool full_rank = true;
  const Eigen::MatrixXd covariance = variance * inverse_of(minimum.sums, m, full_rank);

  Eigen::MatrixXd middle =
      Eigen::MatrixXd::Zero(chart.kind == ChartKind::cylinder || chart.kind == ChartKind::cone ? 2 : 3, m);
  Eigen::MatrixXd tilt = Eigen::MatrixXd::Zero(2, m), size = Eigen::MatrixXd::Zero(1, m), tube = size;
  Vec3 center = chart.origin;
  double radius = 0;
  if (chart.kind == ChartKind::torus) {
    middle(0, 0) = middle(1, 1) = middle(2, 2) = 1;
    tilt(0, 3) = tilt(1, 4) = 1;
    size(0, 5) = tube(0, 6) = 1;
    radius = chart.ring;
    fit.primitive.tube = chart.tube / place.factor;
    fit.sigma_tube = largest_sigma(tube, covariance) / place.factor;
  } else {
    const int bend = chart.kind == ChartKind::sphere ? 3 : 4;
    radius = 1 / std::max(chart.kappa, 1e-9);
    center -= radius * chart.frame.row(0).transpose();
    size(0, bend) = -radius * radius;
    middle(0, 0) = 1, middle(0, bend) = radius * radius;
    middle(1, 1) = -radius;
    if (chart.kind == ChartKind::sphere)
      middle(2, 2) = -radius;
    else
      tilt(0, 2) = tilt(1, 3) = 1;
    if (chart.kind == ChartKind::circle) middle(2, 3) = radius, middle(2, 5) = 1;
    if (chart.kind == ChartKind::cone) {
      // The radius is that of the place on the axis nearest to `point`, whatever else moves.
      size(0, 0) = std::tan(chart.psi) * std::sin(chart.psi);
      size(0, 3) = -radius * std::tan(chart.psi);
      middle(0, 0) = std::cos(chart.psi);
      fit.primitive.half_angle = std::abs(chart.psi);
      fit.sigma_half_angle = std::sqrt(std::max(covariance(5, 5), 0.0));
    }
  }
  fit.primitive.point = place.center + center / place.factor;
  fit.primitive.radius = radius / place.factor;
  fit.sigma_radius = largest_sigma(size, covariance) / place.factor;
  fit.sigma_point = largest_sigma(middle, covariance) / place.factor;
  if (chart.kind != ChartKind::sphere) {
    const Vec3 axis = chart.frame.row(2);
    fit.primitive.axis = chart.kind == ChartKind::cone ? Vec3(chart.psi < 0 ? Vec3(-axis) : axis) : oriented(axis);
    fit.sigma_axis = largest_sigma(tilt, covariance);
  }
  fit.determined = full_rank && radius < 1e8 && fit.sigma_radius < loosest_size * fit.primitive.radius &&
                   fit.sigma_axis < loosest_axis && fit.sigma_half_angle < loosest_axis &&
                   (chart.kind != ChartKind::torus || fit.sigma_tube < loosest_size * fit.primitive.tube);
  return fit;
}

// ---------------------------------------------------------------- robust weights

/// What Welsch weights of constant c do to normal noise, for points with one residual or two (curves): the mean
/// weighted square shrinks, and the inverse of the weighted normal matrix is not quite the covariance.
double welsch_shrink(double c) { return c > 0 ? 1 / (1 + 1 / (c * c)) : 1; }
double welsch_growth(double c, bool two_residuals) {
  if (c <= 0) return 1;
  const double k = 1 / (c * c), e = two_residuals ? 1 : 0.5;
  return std::pow(1 + k, 2 + e) / std::pow(1 + 2 * k, 1 + e);
}

std::vector<double> distances_to(const ScaledPoints& points, const Primitive& primitive) {
  std::vector<double> result(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) result[i] = std::abs(distance(primitive, points[i]));
  return result;
}

/// sigma of the good points about a primitive, from the median distance; half of them may be wild.
double median_sigma(const std::vector<double>& distances, bool two_residuals) {
  return median(distances) / (two_residuals ? 1.17741 : 0.67449);
}

// ---------------------------------------------------------------- choosing the basin

struct Noise {
  double known = 0;   ///< sigma in chart units; 0: unknown
  double robust = 0;  ///< Welsch constant
};

/// Robust weights need a start that wild points did not make: fits to the nearer 60 % of the points, again and again
/// (the concentration steps of least trimmed squares).
Minimum trimmed(const ScaledPoints& points, const PrimitiveChart& start, PrimitiveKind kind, int rounds) {
  ScaledPoints kept = points;
  constexpr double settled = 0.999;  // of the cost of the round before: another one hardly tells more
  Minimum at{recentered(start), {}, false};
  double cost = std::numeric_limits<double>::infinity();
  for (int round = 0; round < rounds; ++round) {
    const std::vector<double> away = distances_to(points, fit_of(kind, at, 0, {}).primitive);
    std::vector<double> sorted = away;
    const auto cut = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 3 / 5);
    std::nth_element(sorted.begin(), cut, sorted.end());
    kept.weight.assign(points.size(), 0);
    for (std::size_t i = 0; i < points.size(); ++i)
      kept.weight[i] = away[i] <= *cut ? (points.weight.empty() ? 1 : points.weight[i]) : 0;
    at = minimized(kept, at.chart, 0, 4, 1e-4, 1e-3);
    if (!std::isfinite(at.sums.cost) || at.sums.cost > settled * cost) break;
    cost = at.sums.cost;
  }
  return at;
}

Minimum first_minimum(const ScaledPoints& points, const PrimitiveChart& start, PrimitiveKind kind, double robust,
                      int steps) {
  return robust > 0 ? trimmed(points, start, kind, 1 + steps / 4) : minimized(points, start, 0, steps, 1e-3, 1e-3);
}

/// The best of several starts on a few hundred of the points, which are already scaled.
Minimum best_start(PrimitiveKind kind, const ScaledPoints& points, const std::vector<Vec3>& normals,
                   const std::optional<PrimitiveChart>& given, const Noise& noise) {
  const auto worse = [](const Minimum& a, const Minimum& b) { return !(a.sums.cost <= b.sums.cost); };
  Minimum from_given;
  if (given) {
    from_given = first_minimum(points, *given, kind, noise.robust, 60);
    const double rms = std::sqrt(from_given.sums.squares / std::max(from_given.sums.weight, 1.0));
    if (noise.known > 0 && rms < 1.3 * noise.known) return from_given;
  }
  std::vector<Minimum> tries;
  for (const PrimitiveChart& chart : start_charts(chart_kind(kind), *points.points, normals)) {
    Minimum tried = first_minimum(points, chart, kind, noise.robust, 5);
    if (std::isfinite(tried.sums.cost)) tries.push_back(tried);
  }
  std::stable_sort(tries.begin(), tries.end(),
                   [&](const Minimum& a, const Minimum& b) { return a.sums.cost < b.sums.cost; });
  Minimum best;
  for (std::size_t i = 0; i < tries.size() && i < 3; ++i) {
    const Minimum tried = first_minimum(points, tries[i].chart, kind, noise.robust, 40);
    if (i == 0 || worse(best, tried)) best = tried;
  }
  // The start that was asked for wins unless another place explains the points clearly better.
  if (given && (tries.empty() || !(best.sums.cost < 0.8 * from_given.sums.cost))) return from_given;
  return best;
}

// ---------------------------------------------------------------- plane and line: closed forms

struct Weights {
  std::vector<double> values;  ///< mean 1; empty: all 1
  double unit = 0;             ///< sigma of weight 1, if sigmas were given
  const double* data() const { return values.empty() ? nullptr : values.data(); }
};

struct Flat {
  Vec3 mean = Vec3::Zero();
  Vec3 spread = Vec3::Zero();  ///< of a point along each axis, squared; ascending
  Mat3 axes = Mat3::Identity();
  double weight = 0;
};

/// Mean and principal axes; a second pass where the first took the sums too far from the middle.
std::optional<Flat> flat_of(const std::vector<Vec3>& points, const double* weights, Vec3 origin) {
  Flat flat;
  Mat3 second;
  for (int pass = 0; pass < 2; ++pass) {
    const Moments sums = moments(points, weights, origin);
    if (!std::isfinite(sums.second.sum()) || !sums.first.allFinite() || !(sums.weight > 0)) return {};
    const Vec3 offset = sums.first / sums.weight;
    second = sums.second / sums.weight - offset * offset.transpose();
    flat.weight = sums.weight;
    flat.mean = origin + offset;
    if (offset.squaredNorm() < 100 * second.trace()) break;
    origin = flat.mean;
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(second);
  flat.spread = solver.eigenvalues().cwiseMax(0);
  flat.axes = solver.eigenvectors();
  return flat;
}

/// Small spreads point by point: as eigenvalues they drown in the rounding of the large ones.
void measure_spread(const std::vector<Vec3>& points, const double* weights, Flat& flat) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < points.size(); ++i)
    sum += (weights ? weights[i] : 1) * (flat.axes.transpose() * (points[i] - flat.mean)).cwiseAbs2();
  flat.spread.head<2>() = sum.head<2>() / flat.weight;
}

/// Plane or line from the principal axes: the orthogonal-distance optimum itself.
PrimitiveFit flat_fit(PrimitiveKind kind, const Flat& flat, double count, double known_sigma, double robust) {
  const bool plane = kind == PrimitiveKind::plane;
  PrimitiveFit fit;
  fit.primitive.kind = kind;
  fit.primitive.point = flat.mean;
  fit.primitive.axis = oriented(flat.axes.col(plane ? 0 : 2));
  fit.converged = true;
  const double residual = plane ? flat.spread[0] : flat.spread[0] + flat.spread[1];
  const double equations = plane ? count : 2 * count, unknowns = plane ? 3 : 4;
  const double free = equations - unknowns;
  fit.rms = std::sqrt(residual);
  const double variance = known_sigma > 0 ? known_sigma * known_sigma
                          : free > 0      ? residual * count / free / welsch_shrink(robust)
                                          : 0;
  const double each = std::sqrt(variance * welsch_growth(robust, !plane) / flat.weight);
  fit.sigma_point = each;
  // Not 1 / sqrt(spread) alone: where noise is as wide as the points, the direction is lost.
  const double near = plane ? flat.spread[0] : flat.spread[1], far = plane ? flat.spread[1] : flat.spread[2];
  const double gap = far - near;
  fit.sigma_axis = gap > 1e-13 * flat.spread[2] && gap > 0 ? std::min(each * std::sqrt(far) / gap, pi) : pi;
  fit.determined = fit.sigma_axis < loosest_axis;
  return fit;
}

std::optional<PrimitiveFit> fit_flat(PrimitiveKind kind, const std::vector<Vec3>& points, const Weights& weights,
                                     const PrimitiveFitOptions& options) {
  const double known = weights.unit > 0 ? weights.unit : options.sigma;
  const double count = static_cast<double>(points.size());
  std::optional<Flat> flat = flat_of(points, weights.data(), points[points.size() / 2]);
  if (!flat) return {};
  const bool plane = kind == PrimitiveKind::plane;
  if (flat->spread[plane ? 0 : 1] < 1e-9 * flat->spread[2]) measure_spread(points, weights.data(), *flat);
  PrimitiveFit fit = flat_fit(kind, *flat, count, known, 0);
  if (options.robust <= 0) return fit;

  // Trimmed first, until that hardly moves it, then Welsch weights with a scale that follows the points.
  constexpr int most_trimmings = 8, most_scales = 6;
  constexpr double calm = 0.01;  // of the rms
  int trimmings = 0, weighted = 0;
  bool trimming = true;
  if (options.start && options.start->kind == kind) fit.primitive = *options.start;
  std::vector<double> away(points.size()), w(points.size());
  double scale = known, reach = 0;
  for (int round = 0; round < 60; ++round) {
    for (std::size_t i = 0; i < points.size(); ++i)
      away[i] = std::abs(distance(fit.primitive, points[i])) * (weights.data() ? std::sqrt(weights.values[i]) : 1);
    if (!trimming && known <= 0 && weighted < most_scales) scale = median_sigma(away, !plane);
    reach = options.robust * scale;
    double cut = 0;
    if (trimming) {
      std::vector<double> sorted = away;
      const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 3 / 5);
      std::nth_element(sorted.begin(), at, sorted.end());
      cut = *at;
    }
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double u = reach > 0 ? away[i] / reach : 0;
      w[i] = trimming ? (away[i] <= cut ? 1 : 0) : std::exp(-0.5 * u * u);
      sum += w[i];
      if (weights.data()) w[i] *= weights.values[i];
    }
    flat = flat_of(points, w.data(), flat->mean);
    if (!flat) return {};
    const PrimitiveFit next = flat_fit(kind, *flat, sum, known, options.robust);
    const double change = (next.primitive.point - fit.primitive.point).dot(next.primitive.axis) +
                          (next.primitive.axis - fit.primitive.axis).norm() * std::sqrt(flat->spread[2]);
    const bool settled = weighted >= (known > 0 ? 1 : most_scales) && std::abs(change) <= 1e-9 * fit.rms;
    const bool moved = std::abs(change) > calm * next.rms;
    fit = next;
    if (settled) return fit;
    weighted += !trimming;
    trimming = trimming && ++trimmings < most_trimmings && (moved || trimmings < 2);
  }
  fit.converged = false;
  return fit;
}

// ---------------------------------------------------------------- curved kinds

std::optional<PrimitiveFit> fit_curved(PrimitiveKind kind, const std::vector<Vec3>& points,
                                       const std::vector<Vec3>& normals, const Weights& weights,
                                       const PrimitiveFitOptions& options) {
  Place place;
  const bool sampled = points.size() > enough_to_start * 3 / 2;
  const std::size_t count = sampled ? enough_to_start : points.size();
  // One point of every stretch, at a place within it that no grid of scan lines can follow.
  Random random(1);
  std::vector<std::size_t> sample(count);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t begin = k * points.size() / count, end = (k + 1) * points.size() / count;
    sample[k] = begin + (sampled ? random.below(end - begin) : 0);
  }
  // Of a sphere every number is its own, and any middle of the points will do; along an axis `point` follows the
  // middle.
  std::optional<Flat> flat;
  if (kind == PrimitiveKind::sphere && sampled) {
    std::vector<Vec3> few;
    for (std::size_t k = 0; k < count; ++k) few.push_back(points[sample[k]]);
    flat = flat_of(few, nullptr, few[0]);
  }
  if (!flat || !(flat->spread.sum() > 0)) flat = flat_of(points, nullptr, points[points.size() / 2]);
  if (!flat) return {};
  const double size = std::sqrt(flat->spread.sum());
  place.center = flat->mean;
  if (!(size > 1e-150)) {  // all points are one
    PrimitiveFit fit;
    fit.primitive.kind = kind;
    fit.primitive.point = flat->mean;
    fit.determined = false;
    return fit;
  }
  place.factor = std::exp2(-std::round(std::log2(size)));

  const ScaledPoints all{&points, place.center, place.factor, weights.values};
  const double known = (weights.unit > 0 ? weights.unit : options.sigma) * place.factor;
  const Noise noise{known, options.robust};

  std::vector<Vec3> few_points, few_normals;
  ScaledPoints few{&few_points, Vec3::Zero(), 1, {}};
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = sample[k];
    few_points.push_back(all[i]);
    if (!all.weight.empty()) few.weight.push_back(all.weight[i]);
    if (normals.size() == points.size()) few_normals.push_back(normals[i]);
  }
  std::optional<PrimitiveChart> given;
  if (options.start && options.start->kind == kind) given = chart_of(*options.start, place);
  Minimum best = best_start(kind, few, few_normals, given, noise);
  if (!std::isfinite(best.sums.cost)) return {};

  double reach = 0;
  if (options.robust > 0) {
    const bool circle = kind == PrimitiveKind::circle;
    const auto scale_at = [&](const Minimum& at) {
      if (known > 0) return known;
      std::vector<double> away = distances_to(all, fit_of(kind, at, 0, {}).primitive);
      for (std::size_t i = 0; i < away.size() && !all.weight.empty(); ++i) away[i] *= std::sqrt(all.weight[i]);
      return median_sigma(away, circle);
    };
    for (int round = 0; round < 3; ++round) {
      reach = options.robust * std::max(scale_at(best), 1e-15);
      best = minimized(all, best.chart, reach, 30, 1e-3, 1e-6);
    }
  }
  best = minimized(all, best.chart, reach, 100, 1e-8, 0);
  if (!std::isfinite(best.sums.cost)) return {};

  const double equations = best.sums.count * (kind == PrimitiveKind::circle ? 2 : 1);
  const double free = equations - unknowns_of(best.chart.kind);
  const double mean_square = best.sums.squares / std::max(best.sums.weight, 1e-300);
  double variance = known > 0 ? known * known : free > 0 ? best.sums.squares / free / welsch_shrink(options.robust) : 0;
  // No point is better known than the last bit of its coordinates.
  const double rounding = 2e-16 * (1 + place.center.cwiseAbs().maxCoeff() * place.factor);
  variance = std::max(variance, rounding * rounding) * welsch_growth(options.robust, kind == PrimitiveKind::circle);
  PrimitiveFit fit = fit_of(kind, best, variance, place);
  fit.rms = std::sqrt(mean_square) / place.factor;
  if (options.start && options.start->kind == kind && kind != PrimitiveKind::cone &&
      fit.primitive.axis.dot(options.start->axis) < 0)
    fit.primitive.axis = -fit.primitive.axis;
  if (kind == PrimitiveKind::sphere) fit.primitive.axis = Vec3::UnitZ();
  return fit;
}

/// Points below which a kind is open whatever they say; lines and circles get two equations from each.
std::size_t fewest_points(PrimitiveKind kind) {
  switch (kind) {
    case PrimitiveKind::plane:
      return 3;
    case PrimitiveKind::line:
      return 2;
    case PrimitiveKind::circle:
      return 3;
    case PrimitiveKind::sphere:
      return 4;
    case PrimitiveKind::cylinder:
      return 5;
    case PrimitiveKind::cone:
      return 6;
    case PrimitiveKind::torus:
      return 7;
  }
  return 0;
}

}  // namespace

const char* name_of(PrimitiveKind kind) {
  switch (kind) {
    case PrimitiveKind::plane:
      return "plane";
    case PrimitiveKind::line:
      return "line";
    case PrimitiveKind::circle:
      return "circle";
    case PrimitiveKind::sphere:
      return "sphere";
    case PrimitiveKind::cylinder:
      return "cylinder";
    case PrimitiveKind::cone:
      return "cone";
    case PrimitiveKind::torus:
      return "torus";
  }
  return "";
}

double distance(const Primitive& primitive, const Vec3& point) {
  const Vec3 q = point - primitive.point;
  const double h = q.dot(primitive.axis);
  if (primitive.kind == PrimitiveKind::plane) return h;
  if (primitive.kind == PrimitiveKind::sphere) return q.norm() - primitive.radius;
  const double rho = (q - h * primitive.axis).norm();
  switch (primitive.kind) {
    case PrimitiveKind::line:
      return rho;
    case PrimitiveKind::circle:
      return std::hypot(rho - primitive.radius, h);
    case PrimitiveKind::cone: {
      const double c = std::cos(primitive.half_angle), s = std::sin(primitive.half_angle);
      // Behind the apex the apex itself is nearest.
      if (s > 0 && rho * s * s + (h * s + primitive.radius * c) * c < 0)
        return std::hypot(rho, h + primitive.radius * c / s);
      return (rho - primitive.radius) * c - h * s;
    }
    case PrimitiveKind::torus:
      return std::hypot(rho - primitive.radius, h) - primitive.tube;
    default:
      return rho - primitive.radius;
  }
}

std::optional<PrimitiveFit> fit_primitive(PrimitiveKind kind, const std::vector<Vec3>& points,
                                          const std::vector<Vec3>& normals, const PrimitiveFitOptions& options) {
  if (points.size() < fewest_points(kind)) return {};
  ensure(normals.empty() || normals.size() == points.size(), "one normal for every point, or none");
  Weights weights;
  if (options.sigmas) {
    ensure(options.sigmas->size() == points.size(), "one sigma for every point");
    double sum = 0;
    for (double s : *options.sigmas) {
      if (!(s > 0) || !std::isfinite(s)) return {};
      weights.values.push_back(1 / (s * s));
      sum += weights.values.back();
    }
    const double mean = sum / static_cast<double>(points.size());
    for (double& w : weights.values) w /= mean;
    weights.unit = 1 / std::sqrt(mean);
  }
  const bool flat = kind == PrimitiveKind::plane || kind == PrimitiveKind::line;
  std::optional<PrimitiveFit> fit =
      flat ? fit_flat(kind, points, weights, options) : fit_curved(kind, points, normals, weights, options);
  if (!fit) return {};
  if (kind == PrimitiveKind::plane && !normals.empty()) {
    Vec3 mean = Vec3::Zero();
    for (const Vec3& n : normals) mean += n;
    if (mean.dot(fit->primitive.axis) < 0) fit->primitive.axis = -fit->primitive.axis;
  } else if (flat && options.start && options.start->axis.dot(fit->primitive.axis) < 0) {
    fit->primitive.axis = -fit->primitive.axis;
  }
  return fit;
}

}  // namespace partscribe::geometry
