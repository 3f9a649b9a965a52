#include "geometry/orient_normals.h"

#include <algorithm>
#include <cmath>

#include "core/disjoint_sets.h"
#include "core/parallel.h"
#include "geometry/kd_tree.h"
#include "geometry/thin.h"

namespace partscribe {
namespace {

struct Link {
  double cost;
  std::uint32_t a, b;
};

/// The point of a piece that lies farthest along +x, -x, +y, -y, +z or -z.
std::uint32_t outermost(const std::vector<Vec3>& points, const std::vector<std::uint32_t>& piece, int direction) {
  std::uint32_t best = piece.front();
  const int axis = direction / 2;
  const double sign = direction % 2 ? -1 : 1;
  for (const std::uint32_t i : piece)
    if (sign * points[i][axis] > sign * points[best][axis]) best = i;
  return best;
}

}  // namespace

std::size_t orient_normals(PointCloud& cloud, int neighbours, Context& context) {
  std::vector<std::uint32_t> source;
  for (const std::uint32_t i : thinned(cloud.points, cloud.rejected, 0))
    if (cloud.normals[i].squaredNorm() > 0.25) source.push_back(i);
  std::vector<Vec3> points, normals;
  for (const std::uint32_t i : source) points.push_back(cloud.points[i]), normals.push_back(cloud.normals[i]);
  const std::size_t n = points.size();
  if (n == 0) return 0;
  const KdTree tree(points);
  const auto k = static_cast<std::size_t>(std::max(neighbours, 3));
  std::vector<std::uint32_t> near_of(n * k, ~0u);
  parallel_for(n, context.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    for (std::size_t i = begin; i < end; ++i) {
      tree.nearest(points[i], k, near);
      for (std::size_t m = 0; m < near.size(); ++m) near_of[i * k + m] = near[m].index;
    }
  });
  std::vector<Link> links;
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::size_t m = 0; m < k; ++m) {
      const std::uint32_t j = near_of[i * k + m];
      if (j == ~0u || j == i) continue;
      const Vec3 d = points[j] - points[i];
      const double length = d.norm();
      // Normals that agree, and a step that stays in both tangent planes: across a thin wall the step is steep.
      const double steep = length > 0 ? std::max(std::abs(normals[i].dot(d)), std::abs(normals[j].dot(d))) / length : 0;
      links.push_back({1 - std::abs(normals[i].dot(normals[j])) + steep * steep, std::min(i, j), std::max(i, j)});
    }
  std::sort(links.begin(), links.end(), [](const Link& x, const Link& y) {
    if (x.cost != y.cost) return x.cost < y.cost;
    return x.a != y.a ? x.a < y.a : x.b < y.b;
  });
  // Kruskal; every point knows its sense relative to the root of its tree.
  DisjointSets trees(n);
  std::vector<std::vector<std::uint32_t>> kept(n);
  for (const Link& link : links) {
    if (!trees.unite(link.a, link.b)) continue;
    kept[link.a].push_back(link.b);
    kept[link.b].push_back(link.a);
  }
  std::vector<std::uint8_t> seen(n, 0);
  std::size_t pieces = 0;
  std::vector<std::uint32_t> piece;
  for (std::uint32_t seed = 0; seed < n; ++seed) {
    if (seen[seed]) continue;
    ++pieces;
    piece.assign(1, seed);
    seen[seed] = 1;
    for (std::size_t at = 0; at < piece.size(); ++at) {
      const std::uint32_t i = piece[at];
      for (const std::uint32_t j : kept[i]) {
        if (seen[j]) continue;
        seen[j] = 1;
        // Two normals mirrored in the bisecting plane of the step between them agree: exact on circles and edges.
        const Vec3 d = points[j] - points[i];
        Vec3 carried = normals[i];
        if (d.squaredNorm() > 0 && std::abs(normals[i].dot(normals[j])) < 0.7)
          carried -= 2 * d * (d.dot(normals[i]) / d.squaredNorm());
        if (carried.dot(normals[j]) < 0) normals[j] = -normals[j];
        piece.push_back(j);
      }
    }
    // At the outermost points of a closed piece the normal looks outward; six directions vote.
    std::sort(piece.begin(), piece.end());
    double vote = 0;
    for (int direction = 0; direction < 6; ++direction) {
      const std::uint32_t i = outermost(points, piece, direction);
      vote += (direction % 2 ? -1 : 1) * normals[i][direction / 2];
    }
    if (vote < 0)
      for (const std::uint32_t i : piece) normals[i] = -normals[i];
  }
  for (std::size_t i = 0; i < n; ++i) cloud.normals[source[i]] = normals[i];
  return pieces;
}

}  // namespace partscribe
