#include "geometry/mesh/triangle_mesh.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <unordered_map>

#include "core/disjoint_sets.h"
#include "geometry/mesh/mesh_facets.h"
#include "geometry/points/point_cloud.h"

namespace partscribe::geometry {
namespace {

struct Key {
  std::int64_t x, y, z;
  bool operator==(const Key&) const = default;
};
struct KeyHash {
  std::size_t operator()(const Key& k) const {
    std::uint64_t h = 1469598103934665603ull;
    for (const auto v : {k.x, k.y, k.z}) h = (h ^ std::uint64_t(v)) * 0x9E3779B97F4A7C15ull, h ^= h >> 29;
    return h;
  }
};

}  // namespace

Box3 TriangleMesh::bounds() const {
  Box3 box;
  for (const auto& v : vertices) box.add(v);
  return box;
}

Box3 PointCloud::bounds() const {
  Box3 box;
  for (const auto& p : points) box.add(p);
  return box;
}

MeshTopology topology(const TriangleMesh& mesh) {
  MeshTopology result;
  DisjointSets pieces(mesh.triangles.size());
  result.components = mesh.triangles.size();
  for_each_edge(edge_uses(mesh.triangles), [&](std::span<const EdgeUse> around) {
    if (around.size() == 1) ++result.boundary_edges;
    if (around.size() > 2) ++result.nonmanifold_edges;
    if (around.size() == 2 && around[0].forward == around[1].forward) ++result.inconsistent_edges;
    for (const EdgeUse& use : around) result.components -= pieces.unite(around[0].triangle, use.triangle);
  });
  return result;
}

double area(const TriangleMesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    sum += 0.5 * (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
  return sum;
}

double volume(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return 0;
  const Vec3 o = mesh.vertices.front();  // near the data: far from the origin nothing cancels
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    sum += (mesh.corner(t, 0) - o).dot((mesh.corner(t, 1) - o).cross(mesh.corner(t, 2) - o));
  return sum / 6;
}

Vec3 triangle_normal(const TriangleMesh& mesh, std::size_t t) {
  const Vec3 n = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
  const double length = n.norm();
  return length > 0 ? Vec3(n / length) : Vec3(0, 0, 0);
}

std::vector<Vec3> vertex_normals(const TriangleMesh& mesh) {
  std::vector<Vec3> normals(mesh.vertices.size(), Vec3::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 n = triangle_normal(mesh, t);
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k);
      const Vec3 b = mesh.corner(t, (k + 2) % 3) - mesh.corner(t, k);
      normals[mesh.triangles[t][k]] += std::atan2(a.cross(b).norm(), a.dot(b)) * n;
    }
  }
  for (auto& n : normals) {
    const double length = n.norm();
    if (length > 0) n /= length;
  }
  return normals;
}

TriangleMesh welded(const TriangleMesh& mesh, double tolerance) {
  TriangleMesh result;
  std::vector<std::uint32_t> index(mesh.vertices.size(), ~0u);
  std::unordered_map<Key, std::uint32_t, KeyHash> seen;
  auto quantum = [&](double v) {
    if (tolerance > 0) return static_cast<std::int64_t>(std::llround(v / tolerance));
    const double plus_zero = v + 0.0;
    std::int64_t bits;
    static_assert(sizeof bits == sizeof plus_zero);
    std::memcpy(&bits, &plus_zero, sizeof bits);
    return bits;
  };
  auto use = [&](std::uint32_t v) {
    if (index[v] != ~0u) return index[v];
    const Vec3& p = mesh.vertices[v];
    const auto [it, fresh] = seen.try_emplace({quantum(p.x()), quantum(p.y()), quantum(p.z())},
                                              static_cast<std::uint32_t>(result.vertices.size()));
    if (fresh) result.vertices.push_back(p);
    return index[v] = it->second;
  };
  for (const auto& t : mesh.triangles) {
    const std::array<std::uint32_t, 3> w = {use(t[0]), use(t[1]), use(t[2])};
    if (w[0] != w[1] && w[1] != w[2] && w[2] != w[0]) result.triangles.push_back(w);
  }
  return result;
}

TriangleMesh transformed(const TriangleMesh& mesh, const Pose& pose) {
  TriangleMesh result = mesh;
  for (auto& v : result.vertices) v = pose * v;
  return result;
}

}  // namespace partscribe::geometry
