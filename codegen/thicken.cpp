#include "codegen/thicken.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <set>

#include "geometry/mesh/triangle_mesh.h"

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

/// The direction whose largest angle to a triangle's normal is smallest [Badoiu & Clarkson 2003]; zero if more than a
/// hundredth of the area does not face it.
Vec3 faced_direction(const TriangleMesh& mesh) {
  std::vector<Vec3> normals;
  Vec3 direction = Vec3::Zero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    normals.push_back(triangle_normal(mesh, t));
    direction += (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
  }
  if (!(direction.norm() > 0)) return Vec3::Zero();
  direction.normalize();
  Vec3 center = direction;
  for (int step = 1; step <= 300; ++step) {
    std::size_t worst = 0;
    for (std::size_t t = 1; t < normals.size(); ++t)
      if (normals[t].dot(center) < normals[worst].dot(center)) worst = t;
    center += (normals[worst] - center) / (step + 1);
  }
  // On sheets that turn away somewhere the mean may serve better than the middle of the extremes.
  auto turned_away = [&](const Vec3& d) {
    double area = 0, away = 0;
    for (std::size_t t = 0; t < normals.size(); ++t) {
      const double a = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
      area += a;
      if (normals[t].dot(d) < 0.02) away += a;
    }
    return away / area;
  };
  if (center.norm() > 0 && turned_away(center.normalized()) <= turned_away(direction)) direction = center.normalized();
  return turned_away(direction) < 0.01 ? direction : Vec3::Zero();
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
  if (folds(mesh, normals, thickness))
    if (const Vec3 common = faced_direction(mesh); common.norm() > 0) std::fill(normals.begin(), normals.end(), common);
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
