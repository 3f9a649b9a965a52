#include "geometry/self_intersection.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace partscribe {
namespace {

double side(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return (b - a).cross(c - a).dot(d - a); }

/// Does the open segment p-q pass through the inside of triangle a, b, c?
bool pierces(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const double sp = side(a, b, c, p), sq = side(a, b, c, q);
  if ((sp >= 0 && sq >= 0) || (sp <= 0 && sq <= 0)) return false;
  const double u = side(p, q, a, b), v = side(p, q, b, c), w = side(p, q, c, a);
  return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

}  // namespace

std::vector<std::pair<std::uint32_t, std::uint32_t>> self_intersections(const TriangleMesh& mesh, std::size_t limit) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> result;
  const std::size_t n = mesh.triangles.size();
  std::vector<Box3> boxes(n);
  for (std::size_t t = 0; t < n; ++t)
    for (int k = 0; k < 3; ++k) boxes[t].add(mesh.corner(t, k));
  // Sweep along the longest side.
  Eigen::Index axis = 0;
  mesh.bounds().size().maxCoeff(&axis);
  std::vector<std::uint32_t> order(n);
  for (std::uint32_t t = 0; t < n; ++t) order[t] = t;
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return boxes[a].low[axis] != boxes[b].low[axis] ? boxes[a].low[axis] < boxes[b].low[axis] : a < b;
  });
  for (std::size_t i = 0; i < n && result.size() < limit; ++i) {
    const std::uint32_t a = order[i];
    for (std::size_t j = i + 1; j < n && boxes[order[j]].low[axis] <= boxes[a].high[axis]; ++j) {
      const std::uint32_t b = order[j];
      bool apart = false;
      for (int k = 0; k < 3; ++k)
        apart = apart || boxes[a].low[k] > boxes[b].high[k] || boxes[b].low[k] > boxes[a].high[k];
      if (apart) continue;
      int shared = 0;
      for (const std::uint32_t v : mesh.triangles[a])
        for (const std::uint32_t w : mesh.triangles[b]) shared += v == w;
      if (shared >= 2) continue;
      bool crossing = false;
      for (const auto& [s, t] : {std::pair{a, b}, std::pair{b, a}})
        for (int k = 0; k < 3 && !crossing; ++k) {
          const std::uint32_t p = mesh.triangles[s][k], q = mesh.triangles[s][(k + 1) % 3];
          const auto& tri = mesh.triangles[t];
          // An edge that ends in a corner of the other triangle cannot pass through its inside.
          if (std::count(tri.begin(), tri.end(), p) + std::count(tri.begin(), tri.end(), q) > 0) continue;
          crossing = pierces(mesh.vertices[p], mesh.vertices[q], mesh.vertices[tri[0]], mesh.vertices[tri[1]],
                             mesh.vertices[tri[2]]);
        }
      if (crossing) result.push_back({std::min(a, b), std::max(a, b)});
    }
  }
  std::sort(result.begin(), result.end());
  if (result.size() > limit) result.resize(limit);
  return result;
}

}  // namespace partscribe
