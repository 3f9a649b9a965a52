#include "geometry/normals.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/ensure.h"
#include "core/number.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "geometry/kd_tree.h"
#include "geometry/thin.h"

namespace partscribe {
namespace {

/// The usable points in coordinate order, so that sums, ties and strides never depend on the order in a file.
struct Ordered {
  std::vector<std::uint32_t> source;  // index in the cloud
  std::vector<Vec3> points;
  std::vector<Vec3> rays;  // empty or one each
};

Ordered ordered(const PointCloud& cloud) {
  Ordered result;
  result.source = thinned(cloud.points, cloud.rejected, 0);
  result.points.reserve(result.source.size());
  for (const std::uint32_t i : result.source) result.points.push_back(cloud.points[i]);
  if (!cloud.rays.empty())
    for (const std::uint32_t i : result.source) result.rays.push_back(cloud.rays[i]);
  return result;
}

/// At most `count` indices, evenly spread over [0, size).
std::vector<std::uint32_t> sample(std::size_t size, std::size_t count) {
  std::vector<std::uint32_t> result;
  const std::size_t n = std::min(size, count);
  for (std::size_t i = 0; i < n; ++i) result.push_back(static_cast<std::uint32_t>((2 * i + 1) * size / (2 * n)));
  return result;
}

double nearest_spacing(const std::vector<Vec3>& points, const KdTree& tree, int threads) {
  const auto chosen = sample(points.size(), 20000);
  std::vector<double> distances(chosen.size(), -1);
  parallel_for(chosen.size(), threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    for (std::size_t i = begin; i < end; ++i) {
      tree.nearest(points[chosen[i]], 4, near);
      for (const Neighbour& n : near)
        if (n.sq_distance > 0) {
          distances[i] = std::sqrt(n.sq_distance);
          break;
        }
    }
  });
  std::erase_if(distances, [](double d) { return d < 0; });
  return median(distances);
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

QuadricScale quadric_scale(const std::vector<Vec3>& points, const std::vector<Neighbour>& near, std::size_t count) {
  using Vec6 = Eigen::Matrix<double, 6, 1>;
  using Mat6 = Eigen::Matrix<double, 6, 6>;
  QuadricScale result;
  Vec3 mean = Vec3::Zero();
  for (std::size_t k = 0; k < count; ++k) mean += points[near[k].index];
  mean /= static_cast<double>(count);
  Mat3 cov = Mat3::Zero();
  for (std::size_t k = 0; k < count; ++k) {
    const Vec3 d = points[near[k].index] - mean;
    cov += d * d.transpose();
  }
  cov /= static_cast<double>(count);
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(cov);
  result.extent = std::sqrt(std::max(eigen.eigenvalues()[1], 0.0));
  result.reach = std::sqrt(near[count - 1].sq_distance);
  if (!(result.extent > 1e-3 * std::sqrt(eigen.eigenvalues()[2])) || result.extent <= 0) return result;
  const double unit = std::sqrt(eigen.eigenvalues()[2]);
  std::vector<Vec6> rows(count);
  std::vector<double> heights(count), residuals(count);
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
      a += rows[k] * rows[k].transpose();
      b += rows[k] * heights[k];
    }
    const Vec6 x = a.ldlt().solve(b);
    if (!x.allFinite()) return result;
    std::vector<double> sizes(count);
    sum = 0, used = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const bool in = round == 0 || std::abs(residuals[k]) <= limit;
      residuals[k] = heights[k] - rows[k].dot(x);
      sizes[k] = std::abs(residuals[k]);
      if (in) sum += residuals[k] * residuals[k], ++used;
    }
    // A neighbourhood of few points has no scale of its own to trim by.
    if (count < 24) break;
    limit = 3.5 * 1.4826 * median(sizes) * std::sqrt(static_cast<double>(count) / static_cast<double>(count - 6));
  }
  if (used <= 7) return result;
  const double freedom = static_cast<double>(used) - 6;
  // The median of chi^2 / n lies below 1 (Wilson & Hilferty); medians over the samples are taken later.
  result.sigma = unit * std::sqrt(sum / freedom / std::pow(1 - 2 / (9 * freedom), 3));
  return result;
}

/// The noise along the normal and the pitch, from the smallest neighbourhoods that are wider than the noise is thick.
Level sampling_level(const std::vector<Vec3>& points, const KdTree& tree, int threads) {
  Level best;
  for (std::size_t count = 14; count <= 1000 && count <= points.size(); count *= 2) {
    const auto chosen = sample(points.size(), count < 200 ? 1200 : 400);
    std::vector<QuadricScale> scales(chosen.size());
    parallel_for(
        chosen.size(), threads,
        [&](std::size_t begin, std::size_t end) {
          std::vector<Neighbour> near;
          for (std::size_t i = begin; i < end; ++i) {
            tree.nearest(points[chosen[i]], count, near);
            scales[i] = quadric_scale(points, near, count);
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
    if (sigmas.empty()) continue;
    const Level level{median(sigmas), median(ratios), median(pitches)};
    if (level.flatness < best.flatness || best.pitch == 0) best = level;
    if (best.flatness < 0.22) break;
  }
  return best;
}

/// Points with weights whose neighbourhoods are planes wide enough for good normals.
struct Nodes {
  std::vector<Vec3> points, rays, normals;
  std::vector<double> weights;
  double radius = 0;
};

/// Means over cubes of edge `spacing`. `points` are in coordinate order already.
Nodes averaged(const Ordered& in, double spacing) {
  struct Entry {
    std::array<std::int64_t, 3> cell;
    std::uint32_t index;
  };
  std::vector<Entry> entries(in.points.size());
  for (std::size_t i = 0; i < in.points.size(); ++i) {
    for (int k = 0; k < 3; ++k) entries[i].cell[k] = static_cast<std::int64_t>(std::floor(in.points[i][k] / spacing));
    entries[i].index = static_cast<std::uint32_t>(i);
  }
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return a.cell != b.cell ? a.cell < b.cell : a.index < b.index; });
  Nodes nodes;
  for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
    Vec3 sum = Vec3::Zero(), ray = Vec3::Zero();
    for (end = begin; end < entries.size() && entries[end].cell == entries[begin].cell; ++end) {
      sum += in.points[entries[end].index];
      if (!in.rays.empty()) ray += in.rays[entries[end].index];
    }
    nodes.points.push_back(sum / static_cast<double>(end - begin));
    nodes.weights.push_back(static_cast<double>(end - begin));
    if (!in.rays.empty()) nodes.rays.push_back(ray);
  }
  return nodes;
}

/// Reweighted PCA over all nodes, round by round (every round reads the normals of the round before).
void weighted_normals(Nodes& nodes, std::size_t cap, double sigma, int rounds, int threads) {
  const std::size_t n = nodes.points.size();
  const KdTree tree(nodes.points);
  std::vector<std::uint32_t> links(n * cap), counts(n);
  std::vector<double> reach(n), spread(n, 0);
  tree.nearest_of_each(cap, threads, [&](std::uint32_t i, std::span<const Neighbour> near) {
    std::size_t count = near.size();
    while (nodes.radius > 0 && count > 14 && near[count - 1].sq_distance > nodes.radius * nodes.radius) --count;
    counts[i] = static_cast<std::uint32_t>(count);
    reach[i] = std::sqrt(near[count - 1].sq_distance);
    for (std::size_t k = 0; k < count; ++k) links[i * cap + k] = near[k].index;
  });
  const bool signed_normals = !nodes.rays.empty();
  nodes.normals.assign(n, Vec3::Zero());
  std::vector<Vec3> next(n, Vec3::Zero());
  for (int round = 0; round < std::max(rounds, 1); ++round) {
    parallel_for(n, threads, [&](std::size_t begin, std::size_t end) {
      std::vector<double> weights(cap);
      for (std::size_t i = begin; i < end; ++i) {
        const Vec3& p = nodes.points[i];
        const Vec3 normal = nodes.normals[i];
        const double spatial = 1 / (2 * std::max(0.3 * reach[i] * reach[i], 1e-300));
        const double width = std::max(3 * sigma, spread[i]);
        double sum = 0;
        Vec3 mean = Vec3::Zero();
        for (std::size_t k = 0; k < counts[i]; ++k) {
          const std::uint32_t j = links[i * cap + k];
          const Vec3 d = nodes.points[j] - p;
          double w = nodes.weights[j] * std::exp(-d.squaredNorm() * spatial);
          if (round > 0) {
            const double along = normal.dot(nodes.normals[j]);
            const double agree = signed_normals ? std::max(along, 0.0) : std::abs(along);
            const double off = normal.dot(d) / std::max(width, 1e-300);
            w *= agree * agree * agree * agree * std::exp(-0.5 * off * off);
          }
          weights[k] = w;
          sum += w;
          mean += w * d;
        }
        if (!(sum > 0)) {
          next[i] = normal;
          continue;
        }
        mean /= sum;
        Mat3 cov = Mat3::Zero();
        double total = 0;
        for (std::size_t k = 0; k < counts[i]; ++k) {
          const Vec3 d = nodes.points[links[i * cap + k]] - p - mean;
          cov += weights[k] * d * d.transpose();
          total += weights[k];
        }
        const Eigen::SelfAdjointEigenSolver<Mat3> eigen(cov / total);
        next[i] = eigen.eigenvectors().col(0);
        spread[i] = std::sqrt(std::max(eigen.eigenvalues()[0], 0.0));
        // The largest component positive: a sign that does not depend on the solver's.
        Eigen::Index axis = 0;
        next[i].cwiseAbs().maxCoeff(&axis);
        if (signed_normals ? next[i].dot(nodes.rays[i]) > 0 : next[i][axis] < 0) next[i] = -next[i];
      }
    });
    nodes.normals.swap(next);
  }
}

/// Every point takes the normal of the node whose plane it lies on best, averaged with like-minded ones nearby.
std::vector<Vec3> normals_from_nodes(const Ordered& in, const Nodes& nodes, double spacing, double sigma, int threads) {
  const KdTree tree(nodes.points);
  std::vector<Vec3> result(in.points.size(), Vec3::Zero());
  parallel_for(in.points.size(), threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    for (std::size_t i = begin; i < end; ++i) {
      tree.nearest(in.points[i], 5, near);
      double best_score = std::numeric_limits<double>::infinity();
      Vec3 best = Vec3::Zero();
      for (const Neighbour& n : near) {
        const Vec3& normal = nodes.normals[n.index];
        const double off = normal.dot(in.points[i] - nodes.points[n.index]) / std::max(sigma, 1e-3 * spacing);
        double score = off * off + n.sq_distance / (spacing * spacing);
        if (!in.rays.empty() && normal.dot(in.rays[i]) > 0) score += 100;
        if (score < best_score) best_score = score, best = normal;
      }
      Vec3 sum = Vec3::Zero();
      for (const Neighbour& n : near) {
        const Vec3& normal = nodes.normals[n.index];
        const double along = normal.dot(best);
        if (std::abs(along) < 0.94) continue;
        const double w = 1 / (0.05 * spacing * spacing + n.sq_distance);
        sum += (along > 0 ? w : -w) * normal;
      }
      result[i] = sum.norm() > 0 ? Vec3(sum.normalized()) : best;
    }
  });
  return result;
}

/// Marks points that lie on no neighbour's surface, or that stand alone.
std::vector<std::uint8_t> outliers(const Ordered& in, const KdTree& tree, const std::vector<Vec3>& normals,
                                   double spacing, double sigma, double sigmas, bool given, int threads) {
  constexpr std::size_t looked_at = 12, needed = 3;
  const std::size_t n = in.points.size();
  std::vector<std::uint8_t> result(n, 0);
  if (n < 50) return result;
  // Isolation is judged against the neighbours' own distances: sparse regions are no outliers.
  std::vector<float> third(n);
  std::vector<std::uint32_t> links(n * looked_at);
  tree.nearest_of_each(looked_at + 1, threads, [&](std::uint32_t i, std::span<const Neighbour> near) {
    std::size_t at = 0;
    for (const Neighbour& m : near)
      if (m.index != i && at < looked_at) {
        if (at == 2) third[i] = static_cast<float>(std::sqrt(m.sq_distance));
        links[i * looked_at + at++] = m.index;
      }
  });
  parallel_for(n, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<float> around(looked_at);
    for (std::size_t i = begin; i < end; ++i) {
      std::size_t support = 0;
      for (std::size_t k = 0; k < looked_at; ++k) {
        const std::uint32_t j = links[i * looked_at + k];
        around[k] = third[j];
        const Vec3 d = in.points[i] - in.points[j];
        const double along = normals[i].dot(normals[j]);
        // The mean of two normals is exact on circles, so that curvature does not count; across an edge only the
        // neighbour's own plane is asked. 0.05 rad: what the normals themselves may be wrong by.
        const Vec3 normal =
            std::abs(along) > 0.7 ? Vec3((along > 0 ? normals[i] : -normals[i]) + normals[j]).normalized() : normals[j];
        double off = std::abs(normal.dot(d));
        // Normals of a mesh's vertices are means over its edges, so any of the planes may hold.
        if (given) off = std::min({off, std::abs(normals[i].dot(d)), std::abs(normals[j].dot(d))});
        if (off <= sigmas * sigma + 0.05 * d.norm()) ++support;
      }
      std::nth_element(around.begin(), around.begin() + looked_at / 2, around.end());
      const bool alone = third[i] > 3 * spacing && third[i] > 3 * around[looked_at / 2];
      result[i] = support < needed || alone;
    }
  });
  return result;
}

}  // namespace

SamplingSummary estimate_normals(PointCloud& cloud, const NormalOptions& options, Context& context) {
  ensure(cloud.rays.empty() || cloud.rays.size() == cloud.size(), "one ray per point, or none at all");
  ensure(cloud.normals.empty() || cloud.normals.size() == cloud.size(), "one normal per point, or none at all");
  SamplingSummary summary;
  const std::size_t n = cloud.size();
  if (cloud.rejected.empty()) cloud.rejected.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i)
    if (!cloud.points[i].allFinite()) cloud.rejected[i] = 1;
  const Ordered in = ordered(cloud);
  if (cloud.normals.empty()) cloud.normals.assign(n, Vec3::Zero());

  // Normals that came with the data are kept.
  std::vector<Vec3> normals(in.points.size(), Vec3::Zero());
  std::size_t known = 0;
  for (std::size_t i = 0; i < in.source.size(); ++i) {
    const Vec3& given = cloud.normals[in.source[i]];
    if (!given.allFinite() || given.norm() < 0.1) continue;
    normals[i] = given.normalized();
    ++known;
  }
  const bool all_known = known == in.points.size();
  if (in.points.size() >= 3) {
    context.report("normals", 0);
    const KdTree tree(in.points);
    summary.spacing = nearest_spacing(in.points, tree, context.threads);
    Level level = sampling_level(in.points, tree, context.threads);
    if (level.pitch == 0) level.pitch = summary.spacing;
    summary.sigma = level.sigma;
    if (!all_known) {
      // Radius: `neighbours` points, five times the noise, and noise that turns a plane by less than 0.03 rad (slope
      // error sigma / (r / 2 sqrt(points in r))); a fixed number of points fails where they are dense and noisy.
      std::array<std::vector<double>, 3> axis;
      for (const std::uint32_t i : sample(in.points.size(), 20000))
        for (int k = 0; k < 3; ++k) axis[k].push_back(in.points[i][k]);
      Vec3 size;
      for (int k = 0; k < 3; ++k) {
        std::sort(axis[k].begin(), axis[k].end());
        size[k] = axis[k][axis[k].size() * 99 / 100] - axis[k][axis[k].size() / 100];
      }
      const double by_count = std::sqrt(options.neighbours / pi) * level.pitch;
      const double by_noise = std::max(5 * level.sigma, std::sqrt(2 * level.sigma * level.pitch / (1.77 * 0.03)));
      const double radius = std::max(by_count, std::min(by_noise, size.norm() / 50));
      Nodes nodes;
      std::vector<Vec3> found;
      if (radius < 1.45 * by_count) {
        nodes.points = in.points;
        nodes.rays = in.rays;
        nodes.weights.assign(in.points.size(), 1);
        weighted_normals(nodes, static_cast<std::size_t>(std::max(options.neighbours, 6)), level.sigma, options.rounds,
                         context.threads);
        found = std::move(nodes.normals);
      } else {
        const double spacing = radius / 3.2;
        nodes = averaged(in, spacing);
        nodes.radius = radius;
        weighted_normals(nodes, 72, level.sigma, options.rounds, context.threads);
        found = normals_from_nodes(in, nodes, spacing, level.sigma, context.threads);
      }
      for (std::size_t i = 0; i < found.size(); ++i) {
        if (normals[i].squaredNorm() > 0) continue;
        normals[i] = found[i];
        if (!in.rays.empty() && normals[i].dot(in.rays[i]) > 0) normals[i] = -normals[i];
      }
    }
    context.report("normals", 0.8);
    const auto flags =
        outliers(in, tree, normals, summary.spacing, level.sigma, options.outlier_sigmas, all_known, context.threads);
    const auto count = static_cast<std::size_t>(std::count(flags.begin(), flags.end(), 1));
    // The vertices of a sparse mesh are no samples of its surface: with given normals, a share beyond any scanner's
    // outlier rate says that the test does not apply.
    if (!all_known || count * 20 <= flags.size())
      for (std::size_t i = 0; i < flags.size(); ++i)
        if (flags[i]) cloud.rejected[in.source[i]] = 1;
  }
  for (std::size_t i = 0; i < in.source.size(); ++i) cloud.normals[in.source[i]] = normals[i];
  if (cloud.sigma.size() != n) cloud.sigma.assign(n, static_cast<float>(summary.sigma));
  summary.rejected = static_cast<std::size_t>(
      std::count_if(cloud.rejected.begin(), cloud.rejected.end(), [](std::uint8_t r) { return r != 0; }));
  context.report("normals", 1);
  return summary;
}

}  // namespace partscribe
