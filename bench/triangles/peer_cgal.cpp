// CGAL: edges collapsed in the order and to the places of Lindstrom & Turk, and of Garland & Heckbert's quadrics.
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_placement.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_policies.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include "bench/triangles/peers.h"

namespace bench {
namespace {

namespace sms = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

Mesh into_cgal(const TriangleMesh& mesh) {
  Mesh result;
  for (const Vec3& v : mesh.vertices) result.add_vertex(Kernel::Point_3(v.x(), v.y(), v.z()));
  for (const auto& t : mesh.triangles)
    result.add_face(Mesh::Vertex_index(t[0]), Mesh::Vertex_index(t[1]), Mesh::Vertex_index(t[2]));
  return result;
}

TriangleMesh from_cgal(Mesh& mesh) {
  mesh.collect_garbage();
  TriangleMesh result;
  for (const auto v : mesh.vertices()) {
    const auto& p = mesh.point(v);
    result.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto f : mesh.faces()) {
    std::array<std::uint32_t, 3> t{};
    std::size_t k = 0;
    for (const auto v : CGAL::vertices_around_face(mesh.halfedge(f), mesh)) t[k++] = std::uint32_t(v);
    result.triangles.push_back(t);
  }
  return result;
}

/// CGAL counts edges: three for two triangles, and half as many as the border has besides.
std::size_t edges_for(const Mesh& mesh, double triangles) {
  std::size_t border = 0;
  for (const auto e : mesh.edges()) border += mesh.is_border(e);
  // What is left of a border is not known beforehand; it shrinks about as the lengths of edges grow.
  const double share = std::sqrt(triangles / double(mesh.number_of_faces()));
  return std::size_t(1.5 * triangles + 0.5 * double(border) * share);
}

template <class Collapse>
Simplified timed(const TriangleMesh& source, double triangles, const Collapse& collapse) {
  Mesh mesh = into_cgal(source);
  const std::size_t edges = edges_for(mesh, triangles);
  const double before = processor_seconds();
  collapse(mesh, sms::Count_stop_predicate<Mesh>(edges));
  const double seconds = processor_seconds() - before;
  return {from_cgal(mesh), seconds};
}

Simplified lindstrom_turk(const TriangleMesh& source, double triangles) {
  return timed(source, triangles, [](Mesh& mesh, const auto& stop) {
    sms::edge_collapse(mesh, stop,
                       CGAL::parameters::get_cost(sms::LindstromTurk_cost<Mesh>())
                           .get_placement(sms::LindstromTurk_placement<Mesh>()));
  });
}

/// As CGAL's own example has it: places at which a normal would turn over are refused.
template <class Policies>
Simplified garland_heckbert(const TriangleMesh& source, double triangles) {
  return timed(source, triangles, [](Mesh& mesh, const auto& stop) {
    const Policies policies(mesh);
    const sms::Bounded_normal_change_placement<typename Policies::Get_placement> placement(policies.get_placement());
    sms::edge_collapse(mesh, stop, CGAL::parameters::get_cost(policies.get_cost()).get_placement(placement));
  });
}

}  // namespace

std::vector<Contestant> cgal_simplifiers() {
  return {{"CGAL Lindstrom-Turk", CGAL_VERSION_STR, Knob::count, &lindstrom_turk},
          {"CGAL quadrics", CGAL_VERSION_STR, Knob::count,
           &garland_heckbert<sms::GarlandHeckbert_plane_policies<Mesh, Kernel>>},
          {"CGAL triangle quadrics", CGAL_VERSION_STR, Knob::count,
           &garland_heckbert<sms::GarlandHeckbert_triangle_policies<Mesh, Kernel>>}};
}

}  // namespace bench
