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

/// Does the back come so near to the front somewhere that it would stand in front of it or in its way?
bool crowds(const TriangleMesh& front, const std::vector<Vec3>& normals, double thickness) {
  const MeshDistance distance(front);
  for (std::size_t v = 0; v < normals.size(); ++v)
    if (normals[v].squaredNorm() > 0 &&
        distance.closest_within(front.vertices[v] - thickness * normals[v], 0.5 * thickness))
      return true;
  return false;
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
  if (folds(mesh, normals, thickness) || crowds(mesh, normals, thickness))
    if (const Facing common = facing(mesh, 0.02); common.turned_away < 0.01)
      std::fill(normals.begin(), normals.end(), common.direction);
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
