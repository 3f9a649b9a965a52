#include "fit/uncertainty.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/number.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "fit/correlation.h"
#include "fit/group_effects.h"
#include "fit/refine.h"
#include "geometry/mesh_distance.h"
#include "model/distance.h"

namespace partscribe {
namespace {

/// Of the noise of one point: what is left of it in an instrument's own scale and straightness.
constexpr double floor_share = 0.05;

/// A known deviation along the normal, mm, one number per node.
using Deviation = std::vector<double>;

/// How far a deviation of the data moves the unknowns. What the kernel would set aside counts for little.
Vector effect_of(const Deviation& deviation, const AllPoints& all, const std::vector<double>& weight,
                 const Welsch& kernel, int threads) {
  constexpr int rounds = 3;
  const Matrix& rows = all.jacobian.rows;
  std::vector<double> w = weight, moment(weight.size());
  Vector effect = Vector::Zero(rows.cols());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t k = 0; k < w.size(); ++k) {
      const double left = deviation[k] - rows.row(static_cast<Eigen::Index>(k)).dot(effect);
      if (round > 0) w[k] = weight[k] * kernel.weight(left / all.sigma[all.nodes[k].begin]);
      moment[k] = w[k] * deviation[k];
    }
    const NormalEquations normal = normal_equations(rows, w, moment, threads);
    effect = pseudo_inverse(normal.h) * normal.g;
  }
  return effect.cwiseAbs();
}

/// How deep a triangulated surface lies below the true one: the model's distance at a point of a facet against what its
/// corners' distances would give. Errors of the corners themselves cancel, flat faces give nothing. The corners are taken
/// a little inside their facet, where their nearest face is the facet's own; the mean depth grows by what that cuts off.
Deviation chord_deviation(const Candidate& candidate, const AllPoints& all, const FitInput& input,
                          const ModelDistance& distance, int threads) {
  constexpr double inset = 0.97, whole = (2.0 / 3) / (inset * inset - 1.0 / 3);
  Deviation result;
  const TriangleMesh& mesh = input.scan->mesh;
  const Pose part_from_scan = candidate.scan_from_part.inverse();
  std::vector<std::array<double, 3>> corner(mesh.triangles.size());
  parallel_for(corner.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Vec3 middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
      for (int k = 0; k < 3; ++k)
        corner[t][k] = distance(part_from_scan * (middle + inset * (mesh.corner(t, k) - middle))).distance;
    }
  });
  const MeshDistance nearest(mesh);
  result.assign(all.nodes.size(), 0);
  parallel_for(
      all.nodes.size(), threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          double sum = 0, weights = 0;
          for (std::size_t i = all.nodes[k].begin; i < all.nodes[k].end; ++i) {
            if (!all.used[i]) continue;
            const MeshHit hit = nearest.closest(all.points[i]);
            const auto& t = mesh.triangles[hit.triangle];
            const Vec3 a = mesh.vertices[t[0]], ab = mesh.vertices[t[1]] - a, ac = mesh.vertices[t[2]] - a;
            const Vec3 normal = ab.cross(ac), p = all.points[i] - a;
            const double square = normal.squaredNorm(), w = 1 / (all.sigma[i] * all.sigma[i]);
            if (!(square > 0)) continue;
            const auto inner = [&](double share) { return 1.0 / 3 + (share - 1.0 / 3) / inset; };
            const double v = inner(p.cross(ac).dot(normal) / square), u = inner(ab.cross(p).dot(normal) / square);
            const auto& c = corner[hit.triangle];
            sum += whole * w * (all.at.value[i] - ((1 - u - v) * c[0] + v * c[1] + u * c[2]));
            weights += w;
          }
          if (weights > 0) result[k] = sum / weights;
        }
      },
      64);
  return result;
}

/// What a smoothing of variance `smoothing` per axis does: it replaces each place by the mean of its surroundings, which
/// bend away from the tangent plane. Rounded edges are no part of it: they move no face.
Deviation smoothing_deviation(const Candidate& candidate, const AllPoints& all, double smoothing,
                              const ModelDistance& distance, int threads) {
  constexpr int directions = 8;
  // On a slope a pixel covers more surface; far down, filters that keep steps do not reach across.
  constexpr double least_cosine = 0.6;
  const Pose part_from_scan = candidate.scan_from_part.inverse();
  Deviation result;
  result.assign(all.nodes.size(), 0);
  parallel_for(all.nodes.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const double length = all.jacobian.gradients[k].norm();
      if (!(length > 0.5)) continue;
      const Vec3 normal = all.jacobian.gradients[k] / length;
      const Vec3 foot = all.nodes[k].place - distance(part_from_scan * all.nodes[k].place).distance * normal;
      const Mat3 frame = rotation_onto_axis(normal);
      const int face = all.at.face[all.nodes[k].begin];
      const double cosine = all.cosine.empty() ? 1 : std::max(all.cosine[all.nodes[k].begin], least_cosine);
      const double radius = std::sqrt(smoothing * (1 + 1 / (cosine * cosine)));
      double sum = 0;
      for (int a = 0; a < directions / 2; ++a) {
        const double angle = 2 * pi * a / directions;
        const Vec3 off = radius * (std::cos(angle) * frame.col(0) + std::sin(angle) * frame.col(1));
        const ModelHit one = distance(part_from_scan * (foot + off)), other = distance(part_from_scan * (foot - off));
        if (one.face == face && other.face == face) sum += (one.distance + other.distance) / directions;
      }
      result[k] = -sum;
    }
  });
  return result;
}

/// Where the used points would be without their noise: across the ray of their view, on the surface where that is unknown.
std::vector<Vec3> noise_free_places(const AllPoints& all) {
  std::vector<Vec3> ray(static_cast<std::size_t>(all.group_count), Vec3::Zero());
  const bool across = all.by_view && !all.rays.empty();
  if (across) {
    for (std::size_t i = 0; i < all.points.size(); ++i) ray[static_cast<std::size_t>(all.group[i])] += all.rays[i];
    for (auto& r : ray) r.normalize();
  }
  std::vector<Vec3> places;
  for (std::size_t k = 0; k < all.nodes.size(); ++k)
    for (std::size_t i = all.nodes[k].begin; i < all.nodes[k].end; ++i) {
      if (!all.used[i]) continue;
      const Vec3& r = ray[static_cast<std::size_t>(all.group[i])];
      places.push_back(across ? Vec3(all.points[i] - all.points[i].dot(r) * r)
                              : Vec3(all.points[i] - all.at.value[i] * all.jacobian.gradients[k]));
    }
  return places;
}

/// Sums over the points of each node, and of each group, as if the kernel were least squares: a residual is
/// psi(u) sigma / E psi', a weight 1 / sigma^2.
struct Sums {
  std::vector<double> weight, pull;  // per node
  std::vector<GroupSums> groups;
};

Sums sums_of(const AllPoints& all, const Unknowns& unknowns, const Welsch& kernel, double slope, int threads) {
  constexpr std::size_t block = 256;
  const std::size_t n = all.nodes.size(), blocks = (n + block - 1) / block, m = static_cast<std::size_t>(all.group_count);
  const Eigen::Index columns = all.jacobian.rows.cols();
  const GroupSums empty{Matrix::Zero(6, 6), Matrix::Zero(6, columns), Vector::Zero(6)};
  Sums sums{std::vector<double>(n, 0), std::vector<double>(n, 0), std::vector<GroupSums>(m, empty)};
  std::vector<std::vector<GroupSums>> parts(blocks);
  parallel_for(
      blocks, threads,
      [&](std::size_t begin, std::size_t end) {
        std::vector<double> weight(m), pull(m);
        for (std::size_t b = begin; b < end; ++b) {
          parts[b].assign(m, empty);
          for (std::size_t k = b * block; k < std::min(n, (b + 1) * block); ++k) {
            std::fill(weight.begin(), weight.end(), 0), std::fill(pull.begin(), pull.end(), 0);
            for (std::size_t i = all.nodes[k].begin; i < all.nodes[k].end; ++i) {
              if (!all.used[i]) continue;
              const double unit = 1 / all.sigma[i];
              const auto g = static_cast<std::size_t>(all.group[i]);
              weight[g] += unit * unit;
              pull[g] += kernel.psi(all.at.value[i] * unit) * unit / slope;
            }
            const auto v = motion_row(all.nodes[k].place, all.jacobian.gradients[k], unknowns.center(), unknowns.size());
            const Vector j = all.jacobian.rows.row(static_cast<Eigen::Index>(k)).transpose();
            for (std::size_t g = 0; g < m; ++g) {
              if (weight[g] == 0) continue;
              sums.weight[k] += weight[g], sums.pull[k] += pull[g];
              parts[b][g].motion += weight[g] * v * v.transpose();
              parts[b][g].coupling += weight[g] * v * j.transpose();
              parts[b][g].pull += pull[g] * v;
            }
          }
        }
      },
      1);
  for (const auto& part : parts)
    for (std::size_t g = 0; g < m; ++g) {
      sums.groups[g].motion += part[g].motion;
      sums.groups[g].coupling += part[g].coupling;
      sums.groups[g].pull += part[g].pull;
    }
  std::erase_if(sums.groups, [](const GroupSums& g) { return g.motion.trace() == 0; });
  return sums;
}

}  // namespace

Uncertainty uncertainty_of(const Candidate& candidate, const AllPoints& all, const FitInput& input,
                           const Unknowns& unknowns, const Welsch& kernel, Context& context) {
  Uncertainty result;
  const std::size_t parameters = unknowns.free_parameters().size();
  result.noise.assign(parameters, 0);
  result.views = result.facets = result.filter = result.noise;

  double slope = 0, square = 0, used = 0, weights = 0, squares = 0;
  std::vector<double> residuals, sigmas;
  std::vector<int> group;
  for (std::size_t i = 0; i < all.points.size(); ++i) {
    if (!all.used[i]) continue;
    const double u = all.at.value[i] / all.sigma[i], psi = kernel.psi(u), w = kernel.weight(u);
    slope += kernel.slope(u), square += psi * psi, used += 1;
    weights += w, squares += w * all.at.value[i] * all.at.value[i];
    residuals.push_back(psi), sigmas.push_back(all.sigma[i]);
    group.push_back(all.by_view ? all.group[i] : 0);
  }
  if (used <= double(unknowns.count()) || !(slope > 0) || !(square > 0)) return result;
  slope /= used, square /= used;
  // The weighted square underestimates a Gaussian's by 1 + 1/c^2.
  result.rms = std::sqrt(squares / std::max(weights, 1e-300) * (1 + 1 / (kernel.c * kernel.c)));

  const Correlation correlation =
      correlation_of(noise_free_places(all), residuals, group, all.by_view ? all.group_count : 1, context.threads);
  result.points_per_independent = correlation.points_per_independent;
  const double freedom = used / (used - double(unknowns.count()));
  const double noise = square / (slope * slope) * correlation.points_per_independent * freedom;

  const Sums sums = sums_of(all, unknowns, kernel, slope, context.threads);
  const Matrix h_inverse =
      pseudo_inverse(normal_equations(all.jacobian.rows, sums.weight, sums.pull, context.threads).h);
  auto fill = [&](std::vector<double>& column, const Vector& spread) {
    for (std::size_t k = 0; k < parameters; ++k) column[k] = spread[static_cast<Eigen::Index>(k)];
  };
  fill(result.noise, (noise * h_inverse.diagonal()).cwiseMax(0).cwiseSqrt());

  Values values;
  for (const auto& p : candidate.parameters) values[p.name] = p.value;
  const ModelDistance distance(bare_model(candidate), values);
  const bool sampled_facets =
      input.scan && !input.scan->mesh.empty() && input.scan->cloud.size() > input.scan->mesh.vertices.size();
  // A drawn mesh was never registered.
  if (!sampled_facets) {
    const GroupEffects effects = group_effects(sums.groups, h_inverse, noise);
    fill(result.views, effects.covariance.diagonal().cwiseMax(0).cwiseSqrt());
  }
  if (sampled_facets) {
    const Deviation chords = chord_deviation(candidate, all, input, distance, context.threads);
    fill(result.facets, effect_of(chords, all, sums.weight, kernel, context.threads));
  } else if (correlation.smoothing > 0) {
    const Deviation smoothed =
        smoothing_deviation(candidate, all, correlation.smoothing, distance, context.threads);
    fill(result.filter, effect_of(smoothed, all, sums.weight, kernel, context.threads));
  }
  result.floor = floor_share * median_in_place(sigmas);
  return result;
}

}  // namespace partscribe
