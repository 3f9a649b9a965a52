// PMP: vertices decimated by quadrics to a count, and by quadrics within its Hausdorff distance; its sources as handed.
#include "bench/triangles/peers.h"

#ifdef PARTSCRIBE_HAS_PMP
#include <pmp/algorithms/decimation.h>
#include <pmp/surface_mesh.h>

#include <cmath>
#endif

namespace bench {
#ifdef PARTSCRIBE_HAS_PMP
namespace {

/// `error` 0: no bound but the count of vertices. Its quadrics do not know of borders, which wear off unless only
/// others are selected.
Simplified decimated_by_pmp(const TriangleMesh& source, std::size_t vertices, double error, bool lock_border) {
  pmp::SurfaceMesh mesh;
  for (const Vec3& v : source.vertices) mesh.add_vertex(pmp::Point(v.x(), v.y(), v.z()));
  for (const auto& t : source.triangles) mesh.add_triangle(pmp::Vertex(t[0]), pmp::Vertex(t[1]), pmp::Vertex(t[2]));
  if (lock_border) {
    auto selected = mesh.add_vertex_property<bool>("v:selected", false);
    for (const auto v : mesh.vertices()) selected[v] = !mesh.is_boundary(v);
  }
  const double before = processor_seconds();
  pmp::decimate(mesh, unsigned(vertices), 0, 0, 0, 0, pmp::Scalar(error));
  const double seconds = processor_seconds() - before;
  mesh.garbage_collection();
  TriangleMesh result;
  for (const auto v : mesh.vertices()) {
    const auto& p = mesh.position(v);
    result.vertices.emplace_back(p[0], p[1], p[2]);
  }
  for (const auto f : mesh.faces()) {
    std::array<std::uint32_t, 3> t{};
    std::size_t k = 0;
    for (const auto v : mesh.vertices(f)) t[k++] = v.idx();
    result.triangles.push_back(t);
  }
  return {std::move(result), seconds};
}

/// It counts vertices: half as many as triangles, and those of the border again by half.
template <bool lock_border>
Simplified pmp_to_count(const TriangleMesh& source, double triangles) {
  const double border = double(topology(source).boundary_edges);
  const double share = lock_border ? 1 : std::sqrt(triangles / double(source.triangles.size()));
  return decimated_by_pmp(source, std::size_t(0.5 * (triangles + border * share)), 0, lock_border);
}
template <bool lock_border>
Simplified pmp_within(const TriangleMesh& source, double error) {
  return decimated_by_pmp(source, 3, error, lock_border);
}

}  // namespace

std::vector<Contestant> pmp_simplifiers() {
  const std::string version = "sources as handed";
  return {{"PMP quadrics", version, Knob::count, &pmp_to_count<false>},
          {"PMP quadrics, border locked", version, Knob::count, &pmp_to_count<true>, true},
          {"PMP Hausdorff", version, Knob::error, &pmp_within<false>},
          {"PMP Hausdorff, border locked", version, Knob::error, &pmp_within<true>, true}};
}
#else
std::vector<Contestant> pmp_simplifiers() {
  return {{"PMP quadrics", "", Knob::count, {}}, {"PMP Hausdorff", "", Knob::error, {}}};
}
#endif

}  // namespace bench
