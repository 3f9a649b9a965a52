#include "geometry/mesh/pseudonormals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace partscribe::geometry {
namespace {

/// Equal positions get one number.
std::vector<std::uint32_t> united_vertices(const std::vector<Vec3>& vertices, std::size_t& count) {
  std::vector<std::uint32_t> order(vertices.size()), united(vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const Vec3 &p = vertices[a], &q = vertices[b];
    return p.x() != q.x() ? p.x() < q.x() : p.y() != q.y() ? p.y() < q.y() : p.z() != q.z() ? p.z() < q.z() : a < b;
  });
  count = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || vertices[order[i]] != vertices[order[i - 1]]) ++count;
    united[order[i]] = static_cast<std::uint32_t>(count - 1);
  }
  return united;
}

/// Numbers every triangle's edges; triangles over the same two places share a number. Sorted within the lists of a
/// vertex, which are short, instead of over all edges.
std::size_t number_edges(const TriangleMesh& mesh, const std::vector<std::uint32_t>& united, std::size_t vertices,
                         std::vector<std::array<std::uint32_t, 3>>& edge) {
  struct Use {
    std::uint32_t other, triangle;
    std::uint8_t k;
  };
  auto ends = [&](std::size_t t, std::size_t k) {
    const std::uint32_t a = united[mesh.triangles[t][k]], b = united[mesh.triangles[t][(k + 1) % 3]];
    return std::pair(std::min(a, b), std::max(a, b));
  };
  std::vector<std::uint32_t> start(vertices + 1, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) ++start[ends(t, k).first + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<Use> uses(mesh.triangles.size() * 3);
  std::vector<std::uint32_t> fill(start.begin(), start.end() - 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = ends(t, k);
      uses[fill[low]++] = {high, static_cast<std::uint32_t>(t), static_cast<std::uint8_t>(k)};
    }
  edge.resize(mesh.triangles.size());
  std::uint32_t count = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    const auto begin = uses.begin() + start[v], end = uses.begin() + start[v + 1];
    std::stable_sort(begin, end, [](const Use& a, const Use& b) { return a.other < b.other; });
    for (auto it = begin; it != end; ++it) {
      if (it == begin || it->other != (it - 1)->other) ++count;
      edge[it->triangle][it->k] = count - 1;
    }
  }
  return count;
}

}  // namespace

Pseudonormals pseudonormals(const TriangleMesh& mesh) {
  Pseudonormals result;
  const std::size_t count = mesh.triangles.size();
  std::size_t vertices = 0;
  result.united = united_vertices(mesh.vertices, vertices);
  const std::size_t edges = number_edges(mesh, result.united, vertices, result.edge);

  std::vector<Vec3> face(count);
  result.corner_normals.assign(vertices, Vec3::Zero());
  for (std::size_t t = 0; t < count; ++t) {
    face[t] = triangle_normal(mesh, t);
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k);
      const Vec3 b = mesh.corner(t, (k + 2) % 3) - mesh.corner(t, k);
      result.corner_normals[result.united[mesh.triangles[t][std::size_t(k)]]] +=
          std::atan2(a.cross(b).norm(), a.dot(b)) * face[t];
    }
  }
  auto sum_edges = [&] {
    result.edge_normals.assign(edges, Vec3::Zero());
    for (std::size_t t = 0; t < count; ++t)
      for (std::size_t k = 0; k < 3; ++k) result.edge_normals[result.edge[t][k]] += face[t];
  };
  sum_edges();
  // A triangle without area stands for the faces behind it: lend it their mean normal, so that an edge that
  // meets the solid only through such a sliver still knows both of its sides.
  bool lent = false;
  for (std::size_t t = 0; t < count; ++t) {
    if (face[t] != Vec3::Zero()) continue;
    auto length = [&](int k) { return (mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k)).norm(); };
    int longest = 0;
    for (int k = 1; k < 3; ++k)
      if (length(k) > length(longest)) longest = k;
    const Vec3 behind = result.of_edge(t, (longest + 1) % 3) + result.of_edge(t, (longest + 2) % 3);
    if (behind.norm() > 0) face[t] = behind.normalized(), lent = true;
  }
  if (lent) sum_edges();
  return result;
}

}  // namespace partscribe::geometry
