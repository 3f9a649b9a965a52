// OpenMesh: vertices decimated by quadrics to a count, and by quadrics within its Hausdorff module's tolerance.
#include "bench/triangles/peers.h"

#ifdef PARTSCRIBE_HAS_OPENMESH
#include <OpenMesh/Core/System/config.h>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModHausdorffT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#endif

namespace bench {
#ifdef PARTSCRIBE_HAS_OPENMESH
namespace {

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using OpenTriangles = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

/// Normals must not turn over; `tolerance` 0: no bound but the count. Its quadrics do not know of borders, which wear
/// off unless they are locked.
Simplified decimated_by_openmesh(const TriangleMesh& source, std::size_t count, double tolerance, bool lock_border) {
  using namespace OpenMesh::Decimater;
  OpenTriangles mesh;
  // The decimater would give them back before what it deleted is taken out.
  mesh.request_vertex_status(), mesh.request_edge_status(), mesh.request_face_status();
  for (const Vec3& v : source.vertices) mesh.add_vertex({v.x(), v.y(), v.z()});
  for (const auto& t : source.triangles)
    mesh.add_face(OpenTriangles::VertexHandle(int(t[0])), OpenTriangles::VertexHandle(int(t[1])),
                  OpenTriangles::VertexHandle(int(t[2])));
  mesh.request_face_normals();
  if (lock_border)
    for (const auto v : mesh.vertices()) mesh.status(v).set_locked(mesh.is_boundary(v));
  const double before = processor_seconds();
  mesh.update_face_normals();
  {
    DecimaterT<OpenTriangles> decimater(mesh);
    typename ModQuadricT<OpenTriangles>::Handle quadric;
    typename ModNormalFlippingT<OpenTriangles>::Handle flipping;
    typename ModHausdorffT<OpenTriangles>::Handle hausdorff;
    decimater.add(quadric);
    decimater.module(quadric).unset_max_err();
    decimater.add(flipping);
    if (tolerance > 0) {
      decimater.add(hausdorff);
      decimater.module(hausdorff).set_tolerance(tolerance);
    }
    decimater.initialize();
    if (tolerance > 0)
      decimater.decimate();
    else
      decimater.decimate_to_faces(0, count);
  }
  const double seconds = processor_seconds() - before;
  mesh.garbage_collection();
  TriangleMesh result;
  for (const auto v : mesh.vertices()) {
    const auto& p = mesh.point(v);
    result.vertices.emplace_back(p[0], p[1], p[2]);
  }
  for (const auto f : mesh.faces()) {
    std::array<std::uint32_t, 3> t{};
    std::size_t k = 0;
    for (auto v = mesh.cfv_iter(f); v.is_valid(); ++v) t[k++] = std::uint32_t(v->idx());
    result.triangles.push_back(t);
  }
  return {std::move(result), seconds};
}

template <bool lock_border>
Simplified by_quadrics(const TriangleMesh& source, double triangles) {
  return decimated_by_openmesh(source, std::size_t(triangles), 0, lock_border);
}
template <bool lock_border>
Simplified within_hausdorff(const TriangleMesh& source, double error) {
  return decimated_by_openmesh(source, 0, error, lock_border);
}

}  // namespace

std::vector<Contestant> openmesh_simplifiers() {
  const std::string version = std::to_string(OM_GET_VER) + "." + std::to_string(OM_GET_MAJ);
  return {{"OpenMesh quadrics", version, Knob::count, &by_quadrics<false>},
          {"OpenMesh quadrics, border locked", version, Knob::count, &by_quadrics<true>, true},
          {"OpenMesh Hausdorff", version, Knob::error, &within_hausdorff<false>},
          {"OpenMesh Hausdorff, border locked", version, Knob::error, &within_hausdorff<true>, true}};
}
#else
std::vector<Contestant> openmesh_simplifiers() {
  return {{"OpenMesh quadrics", "", Knob::count, {}}, {"OpenMesh Hausdorff", "", Knob::error, {}}};
}
#endif

}  // namespace bench
