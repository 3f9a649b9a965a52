#include "geometry/normals/local_noise.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/number.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "geometry/decompose.h"
#include "geometry/points/thin.h"

namespace partscribe::geometry {
namespace {

std::vector<std::uint32_t> sample(std::size_t size, std::size_t count) {
  std::vector<std::uint32_t> result;
  const std::size_t n = std::min(size, count);
  for (std::size_t i = 0; i < n; ++i) result.push_back(static_cast<std::uint32_t>((2 * i + 1) * size / (2 * n)));
  return result;
}

/// What the neighbourhoods of one size say.
struct Level {
  double sigma = 0;     // of the residuals from a quadric
  double flatness = 1;  // sigma / extent: near 1 the neighbourhood is a ball of noise, not a piece of surface
  double pitch = 0;     // of an even grid with the same number of points per area
};

/// Residual scale of a quadric through the first `count` neighbours; nothing for degenerate ones.
struct QuadricScale {
  double sigma = -1, extent = 0, reach = 0;
};

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// Memory for quadrics, one after the other.
struct QuadricScratch {
  std::vector<Neighbour> near;
  std::vector<Vec6> rows;
  std::vector<double> heights, residuals, sizes;
};

QuadricScale quadric_scale(std::span<const Vec3> points, QuadricScratch& scratch, std::size_t count) {
  auto& [near, rows, heights, residuals, sizes] = scratch;
  QuadricScale result;
  Vec3 mean = Vec3::Zero();
  for (std::size_t k = 0; k < count; ++k) mean += points[near[k].index];
  mean /= static_cast<double>(count);
  Mat3 cov = Mat3::Zero();
  for (std::size_t k = 0; k < count; ++k) {
    const Vec3 d = points[near[k].index] - mean;
    cov.noalias() += d * d.transpose();
  }
  cov /= static_cast<double>(count);
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(cov);
  result.extent = std::sqrt(std::max(eigen.eigenvalues()[1], 0.0));
  result.reach = std::sqrt(near[count - 1].sq_distance);
  if (!(result.extent > 1e-3 * std::sqrt(eigen.eigenvalues()[2])) || result.extent <= 0) return result;
  const double unit = std::sqrt(eigen.eigenvalues()[2]);
  rows.resize(count), heights.resize(count), residuals.resize(count), sizes.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    const Vec3 d = eigen.eigenvectors().transpose() * (points[near[k].index] - mean) / unit;
    const double u = d[2], v = d[1];
    rows[k] << 1, u, v, u * u, u * v, v * v;
    heights[k] = d[0];
  }
  double limit = std::numeric_limits<double>::infinity();
  double sum = 0;
  std::size_t used = 0;
  for (int round = 0; round < 2; ++round) {
    Mat6 a = Mat6::Zero();
    Vec6 b = Vec6::Zero();
    for (std::size_t k = 0; k < count; ++k) {
      if (round > 0 && std::abs(residuals[k]) > limit) continue;
      a.noalias() += rows[k] * rows[k].transpose();
      b += rows[k] * heights[k];
    }
    const Vec6 x = solve_ldlt(a, b);
    if (!x.allFinite()) return result;
    sum = 0, used = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const bool in = round == 0 || std::abs(residuals[k]) <= limit;
      residuals[k] = heights[k] - rows[k].dot(x);
      sizes[k] = std::abs(residuals[k]);
      if (in) sum += residuals[k] * residuals[k], ++used;
    }
    // A neighbourhood of few points has no scale of its own to trim by.
    if (count < 24) break;
    limit =
        3.5 * 1.4826 * median_in_place(sizes) * std::sqrt(static_cast<double>(count) / static_cast<double>(count - 6));
  }
  if (used <= 7) return result;
  const double freedom = static_cast<double>(used) - 6;
  // The median of chi^2 / n lies below 1 (Wilson & Hilferty); medians over the samples are taken later.
  result.sigma = unit * std::sqrt(sum / freedom / std::pow(1 - 2 / (9 * freedom), 3));
  return result;
}

/// What the neighbourhoods of one size say: the middle one, and the flatter ones, which hold no edge.
struct Levels {
  Level middle, flat;
};

/// Of neighbourhoods of `count` points; pitch 0 if they are degenerate.
Levels levels_of(std::span<const Vec3> points, std::size_t count, const NearestPoints& nearest, int threads) {
  constexpr double flatter = 0.25;               // share of the neighbourhoods
  constexpr double quartile_by_chance = 0.6745;  // standard deviations below the middle
  const auto chosen = sample(points.size(), count < 200 ? 1200 : 400);
  std::vector<QuadricScale> scales(chosen.size());
  parallel_for(
      chosen.size(), threads,
      [&](std::size_t begin, std::size_t end) {
        QuadricScratch scratch;
        for (std::size_t i = begin; i < end; ++i) {
          nearest(chosen[i], count, scratch.near);
          scales[i] = quadric_scale(points, scratch, count);
        }
      },
      16);
  std::vector<double> sigmas, ratios, pitches;
  for (const QuadricScale& s : scales) {
    if (s.sigma < 0) continue;
    sigmas.push_back(s.sigma);
    ratios.push_back(s.sigma / s.extent);
    pitches.push_back(s.reach * std::sqrt(pi / static_cast<double>(count)));
  }
  if (sigmas.empty()) return {};
  const double pitch = median(pitches),
               by_chance = 1 + quartile_by_chance / std::sqrt(2 * static_cast<double>(count - 6));
  return {{median(sigmas), median(ratios), pitch},
          {by_chance * quantile(sigmas, flatter), quantile(ratios, flatter), pitch}};
}

}  // namespace

LocalNoise local_noise(std::span<const Vec3> points, const NearestPoints& nearest, int threads) {
  constexpr double thin = 0.22;  // flatness of what shows a surface
  constexpr double ball = 0.75;  // and of what shows noise alone
  constexpr double thin_enough =
      0.3;  // wide neighbourhoods mostly hold an edge: a quarter of them without one speaks for all
  constexpr double no_ball = 0.4;     // flatness of neighbourhoods that are more than noise
  constexpr std::size_t most = 1000;  // points of a neighbourhood
  constexpr std::size_t part = 8;     // no wide neighbourhood holds more of the cloud than one in so many points
  Level best;
  std::vector<Level> flat;
  const auto consider = [&](const Levels& levels) {
    if (!(levels.middle.pitch > 0)) return;
    if (levels.middle.flatness < best.flatness || best.pitch == 0) best = levels.middle;
    flat.push_back(levels.flat);
  };
  const auto answer = [&](bool is_dense) {
    const auto at = std::ranges::find_if(flat, [](const Level& l) { return l.flatness < no_ball; });
    if (at == flat.end()) return LocalNoise{best.sigma, best.pitch, is_dense};
    return LocalNoise{best.sigma, best.pitch, is_dense, at->sigma, at->pitch};
  };
  bool dense = false;
  for (std::size_t count = 14; count <= most && count <= points.size(); count *= 2) {
    const Levels levels = levels_of(points, count, nearest, threads);
    consider(levels);
    if (count == 14) dense = levels.middle.flatness > ball;
    if (best.flatness < thin) return answer(dense);
  }
  const auto flat_enough = [&] {
    return std::ranges::find_if(flat, [](const Level& l) { return l.flatness < thin_enough; });
  };
  // Where points are so dense that the nearest thousand are a ball of noise, every fourth of them shows twice as far.
  for (std::size_t stride = 4; dense && flat_enough() == flat.end() && points.size() / stride > part * most / 2;
       stride *= 4) {
    std::vector<Vec3> some;
    for (std::size_t i = 0; i < points.size(); i += stride) some.push_back(points[i]);
    const KdTree tree(some);
    const auto near = [&](std::uint32_t i, std::size_t count, std::vector<Neighbour>& found) {
      tree.nearest(some[i], count, found);
    };
    for (const std::size_t count : {most / 2, most}) {
      if (count * part > some.size()) break;
      Levels levels = levels_of(some, count, near, threads);
      for (Level* level : {&levels.middle, &levels.flat}) level->pitch /= std::sqrt(static_cast<double>(stride));
      consider(levels);
    }
  }
  const bool told = dense && flat_enough() != flat.end();
  if (told) best = *flat_enough();
  return answer(told);
}

double noise_along_normals(const PointCloud& cloud, int threads) {
  std::vector<Vec3> points;
  for (const std::uint32_t i : thinned(cloud.points, cloud.rejected, 0)) points.push_back(cloud.points[i]);
  if (points.size() < 3) return 0;
  const KdTree tree(points);
  return local_noise(
             points,
             [&](std::uint32_t i, std::size_t count, std::vector<Neighbour>& found) {
               tree.nearest(points[i], count, found);
             },
             threads)
      .sigma;
}

}  // namespace partscribe::geometry
