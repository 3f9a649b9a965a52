#include "bench/invented/csg.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Surface_mesh.h>

#include <cmath>
#include <exception>

#include "core/ensure.h"
#include "core/number.h"
#include "geometry/vec.h"

namespace partscribe::testing {
namespace {

using Mesh = CGAL::Surface_mesh<CGAL::Exact_predicates_inexact_constructions_kernel::Point_3>;

Mesh to_cgal(const TriangleMesh& mesh) {
  Mesh result;
  std::vector<Mesh::Vertex_index> ids;
  for (const auto& v : mesh.vertices) ids.push_back(result.add_vertex({v.x(), v.y(), v.z()}));
  for (const auto& t : mesh.triangles) result.add_face(ids[t[0]], ids[t[1]], ids[t[2]]);
  return result;
}

TriangleMesh from_cgal(const Mesh& mesh) {
  TriangleMesh result;
  std::vector<std::uint32_t> ids(mesh.number_of_vertices() + mesh.number_of_removed_vertices());
  for (const auto v : mesh.vertices()) {
    ids[v] = static_cast<std::uint32_t>(result.vertices.size());
    result.vertices.emplace_back(mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z());
  }
  for (const auto f : mesh.faces()) {
    std::array<std::uint32_t, 3> t;
    int k = 0;
    for (const auto v : CGAL::vertices_around_face(mesh.halfedge(f), mesh)) t[std::size_t(k++)] = ids[v];
    result.triangles.push_back(t);
  }
  return result;
}

}  // namespace

std::optional<TriangleMesh> united_if_possible(const TriangleMesh& a, const TriangleMesh& b) try {
  Mesh first = to_cgal(a), second = to_cgal(b), result;
  if (!CGAL::Polygon_mesh_processing::corefine_and_compute_union(first, second, result)) return {};
  return from_cgal(result);
} catch (const std::exception&) {
  return {};
}

TriangleMesh united(const TriangleMesh& a, const TriangleMesh& b) {
  const auto result = united_if_possible(a, b);
  ensure(result.has_value(), "the solids can be united");
  return *result;
}

TriangleMesh without(const TriangleMesh& a, const TriangleMesh& b) {
  Mesh first = to_cgal(a), second = to_cgal(b), result;
  ensure(CGAL::Polygon_mesh_processing::corefine_and_compute_difference(first, second, result), "the solid can be cut");
  return from_cgal(result);
}

TriangleMesh block(const Vec3& size, const Pose& world_from_block) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back(world_from_block * Vec3((i & 1 ? 0.5 : -0.5) * size.x(), (i & 2 ? 0.5 : -0.5) * size.y(),
                                                    (i & 4 ? 0.5 : -0.5) * size.z()));
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

TriangleMesh rod(const Vec3& foot, const Vec3& axis, double length, double radius, int sectors) {
  TriangleMesh mesh;
  const Mat3 frame = rotation_onto_axis(axis);
  const auto n = static_cast<std::uint32_t>(sectors);
  for (const double z : {0.0, length})
    for (int j = 0; j < sectors; ++j) {
      const double a = 2 * pi * (j + 0.37) / sectors;
      mesh.vertices.push_back(foot + frame * Vec3(radius * std::cos(a), radius * std::sin(a), z));
    }
  mesh.vertices.push_back(foot), mesh.vertices.push_back(foot + length * axis);
  for (std::uint32_t j = 0; j < n; ++j) {
    const std::uint32_t k = (j + 1) % n;
    mesh.triangles.push_back({j, k, n + k});
    mesh.triangles.push_back({j, n + k, n + j});
    mesh.triangles.push_back({2 * n, k, j});
    mesh.triangles.push_back({2 * n + 1, n + j, n + k});
  }
  return mesh;
}

}  // namespace partscribe::testing
