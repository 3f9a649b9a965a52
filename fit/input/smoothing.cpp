#include "fit/input/smoothing.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/number.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "geometry/decompose.h"

namespace partscribe::fit {
namespace {

/// How far the surface lies below a place of a face's tangent plane, and whether that face goes on so far.
struct Sample {
  double height = 0;  ///< mm
  bool same_face = false;
};

/// Nearest to a place beyond an edge are both faces at once, so the number of the nearest does not tell where a face
/// ends. But twice as far down a place above a bent face is as far below it; one beyond an edge is not.
Sample sample_at(const ModelDistance& distance, const Vec3& place, const Vec3& normal, int face) {
  constexpr double alike = 0.5, rounding = 1e-9;  // mm
  const ModelHit hit = distance(place);
  if (hit.face != face || std::abs(hit.distance) < rounding) return {hit.distance, hit.face == face};
  const double opposite = distance(place - 2 * hit.distance * normal).distance;
  return {hit.distance, std::abs(opposite + hit.distance) <= alike * std::abs(hit.distance)};
}

}  // namespace

SmoothingEffect smoothing_effect(const Candidate& candidate, const AllPoints& all, double variance,
                                 const ModelDistance& distance, int threads) {
  constexpr int directions = 8;
  // of the circle that stands for the mean: a mean over 3 x 3 pixels takes in so much more
  constexpr double reach = 1.5;
  // On a slope a pixel covers more surface; far down, filters that keep steps do not reach across.
  constexpr double least_cosine = 0.6;
  const Pose part_from_scan = candidate.scan_from_part.inverse();
  SmoothingEffect result{Deviation(all.nodes.size(), 0), Deviation(all.nodes.size(), 0)};
  parallel_for(all.nodes.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const double length = all.jacobian.gradients[k].norm();
      if (!(length > 0.5)) continue;
      const Vec3 normal = all.jacobian.gradients[k] / length;
      const Vec3 there = part_from_scan * all.nodes[k].place;
      const Vec3 up = part_from_scan.rotation * normal;
      const Vec3 foot = there - distance(there).distance * up;
      const Mat3 frame = rotation_onto_axis(up);
      const int face = all.at.face[all.nodes[k].begin];
      const double cosine = all.cosine.empty() ? 1 : std::max(all.cosine[all.nodes[k].begin], least_cosine);
      const double radius = std::sqrt(variance * (1 + 1 / (cosine * cosine)));
      double own = 0, other = 0;
      for (int a = 0; a < directions / 2; ++a) {
        const double angle = 2 * pi * a / directions;
        const Vec3 off = std::cos(angle) * frame.col(0) + std::sin(angle) * frame.col(1);
        const Sample one = sample_at(distance, foot + radius * off, up, face);
        const Sample two = sample_at(distance, foot - radius * off, up, face);
        if (one.same_face && two.same_face) own += (one.height + two.height) / directions;
        for (const double side : {-reach * radius, reach * radius}) {
          const Sample far = sample_at(distance, foot + side * off, up, face);
          if (!far.same_face) other += far.height / directions;
        }
      }
      result.face[k] = -own, result.rim[k] = -other;
    }
  });
  return result;
}

std::optional<double> chance_by_rims(const AllPoints& all, const std::vector<double>& residuals, const Deviation& rim,
                                     double points_per_independent) {
  constexpr double least_points = 50, share = 0.8, model_error = 0.05;
  constexpr double of_quantile = 0.79;  // variance of its logarithm times the number of independent Gaussians
  std::vector<double> inner, outer, predicted;
  for (std::size_t k = 0; k < all.nodes.size(); ++k)
    for (std::size_t i = all.nodes[k].begin; i < all.nodes[k].end; ++i) {
      if (!all.used[i]) continue;
      (rim[k] == 0 ? inner : outer).push_back(std::abs(residuals[i]) / all.sigma[i]);
      if (rim[k] != 0) predicted.push_back(std::abs(rim[k]) / all.sigma[i]);
    }
  // How far a filter reaches across an edge is not documented.
  constexpr std::array<double, 5> reaches = {0.4, 0.6, 0.8, 1.0, 1.2};
  if (double(outer.size()) < least_points) return std::nullopt;
  const double depth = quantile(predicted, share), at_rims = quantile(outer, share);
  // All points are near rims: a filter must at least have had a visible effect.
  if (double(inner.size()) < least_points)
    return at_rims < reaches.front() * depth ? std::optional<double>(0) : std::nullopt;
  const double usual = quantile(inner, share), found = std::log(at_rims / usual);
  // Magnitudes are correlated by the square of what their Gaussians are.
  const double alike = 1 + (points_per_independent - 1) / 2;
  const double variance =
      of_quantile * alike * (1 / double(outer.size()) + 1 / double(inner.size())) + model_error * model_error;
  auto likelihood = [&](double expected) { return std::exp(-0.5 * std::pow(found - expected, 2) / variance); };
  double smoothed = 0;
  for (const double reach : reaches)
    smoothed += likelihood(std::log(std::hypot(usual, reach * depth) / usual)) / double(reaches.size());
  return smoothed / (smoothed + likelihood(0));
}

SmoothingModel smoothing_model(const AllPoints& all, const Deviation& face, double noise, int bins) {
  const Eigen::Index n = all.jacobian.rows.rows(), first = all.jacobian.rows.cols();
  SmoothingModel result;
  result.rows = all.jacobian.rows;
  double sum = 0;
  for (const double d : face) sum += d * d;
  const double unit = std::sqrt(sum / double(std::max<Eigen::Index>(n, 1)));
  if (!(unit > 0)) return result;
  result.further = bins;
  result.precision = noise / (unit * unit);
  result.rows.conservativeResize(Eigen::NoChange, first + bins);
  result.rows.rightCols(bins).setZero();
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const double cosine = all.cosine.empty() ? 1 : all.cosine[all.nodes[at].begin];
    result.rows(k, first + std::clamp(static_cast<int>(bins * cosine), 0, bins - 1)) = face[at] / unit;
  }
  return result;
}

SmoothingModel rim_model(const AllPoints& all, const Deviation& rim, const Deviation& one_sided, double chance,
                         double noise) {
  constexpr std::size_t most_faces = 40;  // further faces share an unknown with another face
  constexpr double least_depth = 1e-3;    // of the noise of one point: less moves nothing
  std::map<int, std::size_t> columns;
  double sum = 0, count = 0;
  for (std::size_t k = 0; k < rim.size(); ++k) {
    if (rim[k] == 0 && one_sided[k] == 0) continue;
    columns.emplace(all.at.face[all.nodes[k].begin], columns.size() % most_faces);
    sum += rim[k] * rim[k] + one_sided[k] * one_sided[k], count += 1;
  }
  SmoothingModel result{all.jacobian.rows};
  const double unit = std::sqrt(chance * sum / std::max(count, 1.0));
  std::vector<double> sigma = all.sigma;
  if (!(unit > least_depth * median_in_place(sigma))) return result;
  const Eigen::Index first = result.rows.cols(),
                     width = static_cast<Eigen::Index>(std::min(columns.size(), most_faces));
  result.further = 2 * width;
  result.precision = noise / (unit * unit);
  result.rows.conservativeResize(Eigen::NoChange, first + result.further);
  result.rows.rightCols(result.further).setZero();
  for (std::size_t k = 0; k < rim.size(); ++k) {
    if (rim[k] == 0 && one_sided[k] == 0) continue;
    const Eigen::Index column = first + static_cast<Eigen::Index>(columns.at(all.at.face[all.nodes[k].begin]));
    result.rows(static_cast<Eigen::Index>(k), column) = std::sqrt(chance) * rim[k] / unit;
    result.rows(static_cast<Eigen::Index>(k), column + width) = std::sqrt(chance) * one_sided[k] / unit;
  }
  return result;
}

Solution solved(const SmoothingModel& model, const PointSums& sums, int threads) {
  NormalEquations normal = normal_equations(model.rows, sums.weight, sums.pull, threads);
  normal.h.diagonal().tail(model.further).array() += model.precision;
  Solution result{pseudo_inverse(normal.h), {}};
  result.unknowns = result.inverse * normal.g;
  return result;
}

std::vector<double> left_over(const AllPoints& all, const SmoothingModel& model, const Solution& solution) {
  const Vector explained = model.rows * solution.unknowns;
  std::vector<double> rest = all.at.value;
  for (std::size_t k = 0; k < all.nodes.size(); ++k)
    for (std::size_t i = all.nodes[k].begin; i < all.nodes[k].end; ++i)
      rest[i] -= explained[static_cast<Eigen::Index>(k)];
  return rest;
}

double chance_by_incidence(const SmoothingModel& model, const Solution& solution, double noise) {
  if (model.further == 0) return 0;  // nothing is curved
  const Matrix spread = solution.inverse.bottomRightCorner(model.further, model.further);
  const Vector found = solution.unknowns.tail(model.further);
  const double logarithm = 0.5 * std::log(std::max((spread * model.precision).determinant(), 1e-300)) +
                           0.5 * found.dot(solve_ldlt(spread, found)) / noise;
  return 1 / (1 + std::exp(-logarithm));
}

}  // namespace partscribe::fit
