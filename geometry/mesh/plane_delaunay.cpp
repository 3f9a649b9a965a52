#include "geometry/mesh/plane_delaunay.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>

namespace partscribe::geometry {

std::vector<std::array<std::uint32_t, 3>> delaunay_triangles(const std::vector<Vec2>& points) {
  using DelaunayKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using DelaunayVertex = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, DelaunayKernel>;
  CGAL::Delaunay_triangulation_2<DelaunayKernel, CGAL::Triangulation_data_structure_2<DelaunayVertex>> triangulation;
  // One after the other: CGAL's own order for many is a random one.
  decltype(triangulation)::Face_handle near;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const std::size_t before = triangulation.number_of_vertices();
    const auto vertex = triangulation.insert({points[i].x(), points[i].y()}, near);
    if (triangulation.number_of_vertices() > before) vertex->info() = i;
    near = vertex->face();
  }
  std::vector<std::array<std::uint32_t, 3>> triangles;
  if (triangulation.dimension() < 2) return triangles;
  for (auto f = triangulation.finite_faces_begin(); f != triangulation.finite_faces_end(); ++f) {
    std::array<std::uint32_t, 3> t{f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info()};
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    triangles.push_back(t);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

}  // namespace partscribe::geometry
