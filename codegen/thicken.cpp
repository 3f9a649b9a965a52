#include "codegen/thicken.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <set>

#include "geometry/mesh/facing.h"
#include "geometry/mesh/mesh_distance.h"

namespace partscribe::codegen {
namespace {

/// Does a triangle of the back turn by more than 80 degrees against its front?
bool folds(const TriangleMesh& front, const std::vector<Vec3>& normals, double thickness) {
  TriangleMesh back = front;
  for (std::size_t v = 0; v < normals.size(); ++v) back.vertices[v] -= thickness * normals[v];
  for (std::size_t t = 0; t < front.triangles.size(); ++t)
    if (triangle_normal(back, t).dot(triangle_normal(front, t)) < 0.17) return true;
  return false;
}

/// Share of the corners whose back comes to lie in front of the sheet, where it would hide it.
double in_front(const MeshDistance& distance, const TriangleMesh& front, const std::vector<Vec3>& normals,
                double thickness) {
  std::vector<Vec3> back;
  for (std::size_t v = 0; v < normals.size(); ++v) back.push_back(front.vertices[v] - thickness * normals[v]);
  const auto hits = distance.closest(back, 1);
  std::size_t hiding = 0;
  for (std::size_t v = 0; v < back.size(); ++v)
    hiding += (back[v] - hits[v].point).dot(triangle_normal(front, hits[v].triangle)) > 0.05 * thickness;
  return double(hiding) / double(std::max<std::size_t>(back.size(), 1));
}

}  // namespace

std::vector<Vec3> sheet_normals(const std::vector<std::array<double, 3>>& vertices,
                                const std::vector<std::array<std::uint32_t, 3>>& triangles, double thickness) {
  TriangleMesh mesh;
  for (const auto& v : vertices) mesh.vertices.emplace_back(v[0], v[1], v[2]);
  mesh.triangles = triangles;
  std::vector<Vec3> normals = vertex_normals(mesh);
  // The smallest cosine between a corner's normal and its triangles: a plane at that angle moves too little.
  std::vector<double> cosine(vertices.size(), 1);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vec3 n = triangle_normal(mesh, t);
    for (const auto v : triangles[t]) cosine[v] = std::min(cosine[v], std::max(n.dot(normals[v]), 0.5));
  }
  for (std::size_t v = 0; v < normals.size(); ++v) normals[v] /= cosine[v];
  const Facing common = facing(mesh, 0.02);
  if (common.turned_away < 0.01) {
    const std::vector<Vec3> alike(normals.size(), common.direction);
    const MeshDistance distance(mesh);
    if (folds(mesh, normals, thickness) ||
        in_front(distance, mesh, normals, thickness) > in_front(distance, mesh, alike, thickness))
      normals = alike;
  }
  return normals;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> sheet_rim(
    const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> directed;
  for (const auto& t : triangles) {
    for (int k = 0; k < 3; ++k) directed.insert({t[k], t[(k + 1) % 3]});
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> rim;
  for (const auto& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::pair<std::uint32_t, std::uint32_t> edge{t[k], t[(k + 1) % 3]};
      if (!directed.count({edge.second, edge.first})) rim.push_back(edge);
    }
  }
  return rim;
}

}  // namespace partscribe::codegen
