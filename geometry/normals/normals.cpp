#include "geometry/normals/normals.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <span>

#include "core/ensure.h"
#include "core/large_memory.h"
#include "core/number.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "geometry/normals/local_noise.h"
#include "geometry/normals/weighted_planes.h"
#include "geometry/points/kd_tree.h"
#include "geometry/points/thin.h"

namespace partscribe::geometry {
namespace {

using Places = LargeVector<Vec3>;

/// The usable points in coordinate order, so that sums, ties and strides never depend on the order in a file.
struct Ordered {
  std::vector<std::uint32_t> source;  // index in the cloud
  Places points;
  Places rays;  // empty or one each
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

/// The k-th of `count` indices evenly spread over [0, size).
std::size_t sampled(std::size_t k, std::size_t size, std::size_t count) { return (2 * k + 1) * size / (2 * count); }

std::vector<std::uint32_t> sample(std::size_t size, std::size_t count) {
  std::vector<std::uint32_t> result;
  const std::size_t n = std::min(size, count);
  for (std::size_t i = 0; i < n; ++i) result.push_back(static_cast<std::uint32_t>(sampled(i, size, n)));
  return result;
}

constexpr std::size_t spacing_samples = 20000;

/// Diagonal of the box without the outermost hundredth on every side.
double usual_size(const Places& points) {
  const auto chosen = sample(points.size(), 20000);
  std::vector<double> values(chosen.size());
  Vec3 size;
  for (int k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < chosen.size(); ++i) values[i] = points[chosen[i]][k];
    const auto at = [&](std::size_t hundredths) {
      const auto place = values.begin() + static_cast<std::ptrdiff_t>(values.size() * hundredths / 100);
      std::nth_element(values.begin(), place, values.end());
      return *place;
    };
    size[k] = at(99) - at(1);
  }
  return size.norm();
}

/// Points with weights whose neighbourhoods are planes wide enough for good normals.
struct Nodes {
  Places points, rays, normals;
  std::vector<double> weights;
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

/// What a round finds for a block.
struct Planes {
  double x[plane_block], y[plane_block], z[plane_block], spread[plane_block];
};

/// Points in the order of a tree's leaves, with their nearest neighbours: what lies together is worked on together.
struct Neighbourhoods {
  std::size_t rows = 0;              // neighbours of each at most, itself the first
  LargeVector<std::uint32_t> order;  // the point of a place
  std::span<PlaneNode> nodes;        // by place, filled up to whole blocks, and one that is nobody's neighbour
  std::span<std::uint32_t> links;    // by block; places
  std::span<Planes> next;            // by block; not set
  std::span<double> sq_reach;        // of the farthest neighbour
  std::span<std::uint32_t> place;    // of a point
  std::span<float> third;            // distance of the third neighbour
  std::span<double> gaps;            // to the nearest, of samples; out of order
  double spacing = 0;

  Neighbourhoods() = default;
  Neighbourhoods(Neighbourhoods&&) = default;  // a copy would look into the memory of the other
  Neighbourhoods& operator=(Neighbourhoods&&) = default;

  /// For `padded` nodes, neighbours of one that is not counted. Of ten thousand points each array by itself would be in
  /// small pages; all together are in one that is large, touched at once.
  void make_room(std::size_t padded, std::size_t samples) {
    const auto lines = [](std::size_t bytes) { return (bytes + sizeof(Line) - 1) / sizeof(Line); };
    std::size_t used = 0;
    const auto take = [&]<class T>(std::span<T>& some, std::size_t count) {
      if (!memory_.empty()) some = {reinterpret_cast<T*>(memory_.data() + used), count};
      used += lines(count * sizeof(T));
    };
    const auto take_all = [&] {
      used = 0;
      take(nodes, padded + 1), take(links, padded * rows), take(next, padded / plane_block);
      take(sq_reach, padded), take(place, padded), take(third, padded), take(gaps, samples);
    };
    take_all();
    memory_.resize(used);
    take_all();
  }

  std::size_t blocks() const { return sq_reach.size() / plane_block; }
  PlaneBlock block(std::size_t b, std::size_t count) const {
    return {nodes.data(), b * plane_block, links.data() + b * plane_block * rows, count};
  }
  /// The first `count` of the neighbours of a point; there are so many.
  void nearest(std::uint32_t point, std::size_t count, std::vector<Neighbour>& result) const {
    result.clear();
    const std::size_t own = place[point];
    const std::uint32_t* link = links.data() + own / plane_block * plane_block * rows + own % plane_block;
    for (std::size_t k = 0; k < count; ++k) {
      const PlaneNode& other = nodes[link[plane_block * k]];
      const double x = nodes[own].x - other.x, y = nodes[own].y - other.y, z = nodes[own].z - other.z;
      result.push_back({order[link[plane_block * k]], x * x + y * y + z * z});
    }
  }

 private:
  struct alignas(64) Line {
    std::byte bytes[64];
  };
  LargeVector<Line> memory_;  // of all spans
};

/// `rows` neighbours, and beyond the first 14 only those within `radius`; the reach is of the first `used`.
Neighbourhoods neighbourhoods(const Places& points, const KdTree& tree, std::size_t rows, std::size_t used,
                              double radius, int threads) {
  const std::size_t n = points.size(), padded = (n + plane_block - 1) / plane_block * plane_block;
  const auto nobody = static_cast<std::uint32_t>(padded);
  Neighbourhoods result;
  result.rows = rows = std::min(rows, n);
  result.order = tree.order();
  const std::size_t samples = std::min(n, spacing_samples);
  result.make_room(padded, samples);
  for (std::size_t k = 0; k <= padded; ++k) {
    const Vec3& p = points[k < n ? result.order[k] : 0];
    std::construct_at(&result.nodes[k], PlaneNode{p.x(), p.y(), p.z(), k < n ? 1.0 : 0.0});
  }
  const auto links_of = [&](std::size_t own) {
    return result.links.data() + own / plane_block * plane_block * rows + own % plane_block;
  };
  for (std::size_t k = n; k < padded; ++k) {
    result.sq_reach[k] = 0, result.third[k] = 0;
    for (std::size_t row = 0; row < rows; ++row) links_of(k)[plane_block * row] = nobody;
  }
  const std::span<std::uint32_t> place = result.place;
  for (std::size_t k = 0; k < n; ++k) place[result.order[k]] = static_cast<std::uint32_t>(k);
  const std::span<double> gaps = result.gaps;
  std::fill(gaps.begin(), gaps.end(), -1);
  tree.nearest_of_each(rows, threads, [&](std::uint32_t i, std::span<const Neighbour> near) {
    const std::size_t own = place[i];
    std::size_t count = std::min(used, near.size());
    while (radius > 0 && count > 14 && near[count - 1].sq_distance > radius * radius) --count;
    result.sq_reach[own] = near[count - 1].sq_distance;
    if (count == std::min(used, near.size())) count = near.size();
    // Itself first, also where many points coincide.
    std::uint32_t* const to = links_of(own);
    to[0] = static_cast<std::uint32_t>(own);
    std::size_t self = 0;
    while (self < count && near[self].index != i) ++self;
    for (std::size_t k = 1; k < count; ++k) to[plane_block * k] = place[near[k <= self ? k - 1 : k].index];
    for (std::size_t k = count; k < rows; ++k) to[plane_block * k] = nobody;
    result.third[own] = count > 3 ? static_cast<float>(std::sqrt(near[self < 3 ? 3 : 2].sq_distance)) : 0;
    const std::size_t slot = i * samples / n;
    if (sampled(slot, n, samples) == i)
      for (std::size_t k = 0; k < std::min<std::size_t>(4, near.size()) && gaps[slot] < 0; ++k)
        if (near[k].sq_distance > 0) gaps[slot] = std::sqrt(near[k].sq_distance);
  });
  const auto known = std::remove_if(gaps.begin(), gaps.end(), [](double d) { return d < 0; });
  result.spacing = median_in_place({gaps.begin(), known});
  return result;
}

/// What the closed form leaves open: points on a line, or in one place.
Vec3 any_direction(const FoundPlanes& found, std::size_t lane) {
  const auto m = [&](std::size_t i) { return found.moments[i][lane]; };
  Mat3 cov;
  cov << m(0), m(3), m(4), m(3), m(1), m(5), m(4), m(5), m(2);
  if (!cov.allFinite()) return Vec3::Zero();
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(cov);
  const Vec3 normal = eigen.eigenvectors().col(0);
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return normal[axis] < 0 ? Vec3(-normal) : normal;
}

/// Reweighted PCA over all nodes, round by round (every round reads the normals of the round before). Nodes that a
/// round turned by less than `rest` (rad) stay as they are: near edges all rounds are needed, elsewhere they only
/// follow the noise.
void weighted_normals(Neighbourhoods& near, std::size_t rows, const Places& rays, double sigma, double rest, int rounds,
                      int threads) {
  std::vector<std::uint8_t> resting(near.blocks(), 0);
  rows = std::min(rows, near.rows);
  constexpr std::size_t together = 128;
  const auto lanes = [&](std::size_t b) { return std::min(plane_block, near.order.size() - b * plane_block); };
  for (int round = 0; round < std::max(rounds, 1); ++round) {
    parallel_for(
        near.blocks(), threads,
        [&](std::size_t begin, std::size_t end) {
          FoundPlanes found;
          for (std::size_t b = begin; b < end; ++b) {
            if (resting[b]) continue;
            weighted_planes(near.block(b, rows), {&near.sq_reach[b * plane_block], 3 * sigma, round == 0, rays.empty()},
                            found);
            Planes& to = near.next[b];
            for (std::size_t l = 0; l < lanes(b); ++l) {
              Vec3 normal(found.x[l], found.y[l], found.z[l]);
              if (!normal.allFinite()) normal = any_direction(found, l);
              if (!rays.empty() && normal.dot(rays[near.order[b * plane_block + l]]) > 0) normal = -normal;
              to.x[l] = normal.x(), to.y[l] = normal.y(), to.z[l] = normal.z();
              to.spread[l] = std::isfinite(found.spread[l]) ? found.spread[l] : 0;
            }
          }
        },
        together);
    parallel_for(
        near.blocks(), threads,
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t b = begin; b < end; ++b) {
            if (resting[b]) continue;
            const Planes& from = near.next[b];
            double most = 0;
            for (std::size_t l = 0; l < lanes(b); ++l) {
              PlaneNode& node = near.nodes[b * plane_block + l];
              const double x = from.x[l] - node.nx, y = from.y[l] - node.ny, z = from.z[l] - node.nz;
              most = std::max(most, x * x + y * y + z * z);
              node.nx = from.x[l], node.ny = from.y[l], node.nz = from.z[l], node.spread = from.spread[l];
            }
            resting[b] = most < rest * rest;
          }
        },
        together);
  }
}

Vec3 normal_of(const PlaneNode& node) { return {node.nx, node.ny, node.nz}; }

/// Normals that are not zero replace those of the nodes.
void take_over(const Places& normals, Neighbourhoods& near) {
  for (std::size_t k = 0; k < near.order.size(); ++k) {
    const Vec3& normal = normals[near.order[k]];
    if (normal.squaredNorm() > 0)
      near.nodes[k].nx = normal.x(), near.nodes[k].ny = normal.y(), near.nodes[k].nz = normal.z();
  }
}

/// Every point takes the normal of the node whose plane it lies on best, averaged with like-minded ones nearby.
Places normals_from_nodes(const Ordered& in, const Nodes& nodes, const KdTree& tree, double spacing, double sigma,
                          int threads) {
  Places result(in.points.size(), Vec3::Zero());
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

constexpr std::size_t looked_at = 12;  // neighbours of an outlier

/// Marks points that lie on no neighbour's surface, or that stand alone.
std::vector<std::uint8_t> outliers(const Neighbourhoods& near, double sigma, double sigmas, bool given, int threads) {
  constexpr double needed = 3;
  const std::size_t n = near.order.size();
  std::vector<std::uint8_t> result(n, 0);
  if (n < 50) return result;
  // 0.05 rad: what the normals themselves may be wrong by. Normals of a mesh's vertices are means over its edges, so
  // any of the planes may hold.
  const SupportRule rule{sigmas * sigma, 0.05, given, needed};
  parallel_for(
      near.blocks(), threads,
      [&](std::size_t begin, std::size_t end) {
        double support[plane_block];
        std::array<float, looked_at> around;
        for (std::size_t b = begin; b < end; ++b) {
          const PlaneBlock block = near.block(b, looked_at + 1);
          count_support(block, rule, support);
          for (std::size_t l = 0; l < plane_block; ++l) {
            const std::size_t k = b * plane_block + l;
            if (k >= n) break;
            bool alone = near.third[k] > 3 * near.spacing;
            if (alone) {
              // Isolation is judged against the neighbours' own distances: sparse regions are no outliers.
              for (std::size_t m = 0; m < looked_at; ++m)
                around[m] = near.third[block.links[plane_block * (m + 1) + l]];
              std::nth_element(around.begin(), around.begin() + looked_at / 2, around.end());
              alone = near.third[k] > 3 * around[looked_at / 2];
            }
            result[near.order[k]] = support[l] < needed || alone;
          }
        }
      },
      128);
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
  // Normals that came with the data are kept. Zero: not known; empty: none is.
  Places normals;
  std::size_t known = 0;
  if (cloud.normals.empty())
    cloud.normals.assign(n, Vec3::Zero());
  else
    normals.assign(in.points.size(), Vec3::Zero());
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const Vec3& given = cloud.normals[in.source[i]];
    if (!given.allFinite() || given.norm() < 0.1) continue;
    normals[i] = given.normalized();
    ++known;
  }
  const bool all_known = known == in.points.size();
  if (in.points.size() >= 3) {
    context.report("normals", 0);
    const KdTree tree(in.points);
    const auto neighbours = static_cast<std::size_t>(std::max(options.neighbours, 6));
    const auto close = [&](std::size_t count) {
      return neighbourhoods(in.points, tree, std::max(count, looked_at + 1), count, 0, context.threads);
    };
    // Of a small cloud the samples are a good part: their neighbours are found with those of all others.
    constexpr std::size_t small = 50000;
    Neighbourhoods near;
    if (in.points.size() < small) near = close(neighbours);
    const auto nearest = [&](std::uint32_t i, std::size_t count, std::vector<Neighbour>& found) {
      if (count <= near.rows)
        near.nearest(i, count, found);
      else
        tree.nearest(in.points[i], count, found);
    };
    LocalNoise level = local_noise(in.points, nearest, context.threads);
    summary.sigma = level.sigma;
    if (level.pitch == 0 && near.rows == 0) near = close(neighbours);
    if (level.pitch == 0) level.pitch = near.spacing;
    if (!all_known) {
      // Radius: `neighbours` points, and as far as the part is not small five times the noise and noise that turns a
      // plane by less than 0.03 rad (slope error sigma / (r / 2 sqrt(points in r))); a fixed number of points fails
      // where they are dense and noisy. What is narrower than the noise is thick is a ball of noise, whatever the
      // part's size.
      const double by_count = std::sqrt(options.neighbours / pi) * level.pitch,
                   thickness = thickness_of_noise(level.sigma);
      const double by_noise = std::max(thickness, std::sqrt(2 * level.sigma * level.pitch / (1.77 * 0.03)));
      const double thick = level.dense ? thickness : 0;
      const double radius = std::max({by_count, std::min(by_noise, usual_size(in.points) / 50), thick});
      const double in_radius = pi * radius * radius / (level.pitch * level.pitch);
      const auto slope_error = [&](double reach, double points) {
        return 2 * level.sigma / (reach * std::sqrt(points));
      };
      if (radius < 1.45 * by_count) {
        const double wider = std::max(by_count, thick) / by_count;
        const auto wanted = static_cast<std::size_t>(static_cast<double>(neighbours) * wider * wider);
        if (near.rows < wanted) near = close(wanted);
        weighted_normals(near, wanted, in.rays, level.sigma, slope_error(by_count * wider, static_cast<double>(wanted)),
                         options.rounds, context.threads);
      } else {
        const double spacing = radius / 3.2;
        Nodes nodes = averaged(in, spacing);
        const KdTree node_tree(nodes.points);
        Neighbourhoods around = neighbourhoods(nodes.points, node_tree, 72, 72, radius, context.threads);
        for (std::size_t k = 0; k < around.order.size(); ++k) around.nodes[k].weight = nodes.weights[around.order[k]];
        weighted_normals(around, 72, nodes.rays, level.sigma, slope_error(radius, in_radius), options.rounds,
                         context.threads);
        nodes.normals.resize(nodes.points.size());
        for (std::size_t k = 0; k < around.order.size(); ++k)
          nodes.normals[around.order[k]] = normal_of(around.nodes[k]);
        const auto found = normals_from_nodes(in, nodes, node_tree, spacing, level.sigma, context.threads);
        normals.resize(in.points.size(), Vec3::Zero());
        for (std::size_t i = 0; i < found.size(); ++i)
          if (!(normals[i].squaredNorm() > 0))
            normals[i] = !in.rays.empty() && found[i].dot(in.rays[i]) > 0 ? Vec3(-found[i]) : found[i];
      }
    }
    context.report("normals", 0.8);
    if (near.rows == 0) near = close(looked_at + 1);
    if (!normals.empty()) take_over(normals, near);
    summary.spacing = near.spacing;
    const auto flags = outliers(near, level.sigma, options.outlier_sigmas, all_known, context.threads);
    const auto count = static_cast<std::size_t>(std::count(flags.begin(), flags.end(), 1));
    // The vertices of a sparse mesh are no samples of its surface: with given normals, a share beyond any scanner's
    // outlier rate says that the test does not apply.
    if (!all_known || count * 20 <= flags.size())
      for (std::size_t i = 0; i < flags.size(); ++i)
        if (flags[i]) cloud.rejected[in.source[i]] = 1;
    for (std::size_t k = 0; k < near.order.size(); ++k)
      cloud.normals[in.source[near.order[k]]] = normal_of(near.nodes[k]);
  } else {
    for (std::size_t i = 0; i < normals.size(); ++i) cloud.normals[in.source[i]] = normals[i];
  }
  if (cloud.sigma.size() != n) cloud.sigma.assign(n, static_cast<float>(summary.sigma));
  summary.rejected = static_cast<std::size_t>(
      std::count_if(cloud.rejected.begin(), cloud.rejected.end(), [](std::uint8_t r) { return r != 0; }));
  context.report("normals", 1);
  return summary;
}

}  // namespace partscribe::geometry
