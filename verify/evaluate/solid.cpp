#include "verify/evaluate/solid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>
#include <optional>

#include "core/number.h"
#include "geometry/mesh/mesh_facets.h"
#include "verify/report/words.h"

namespace partscribe::verify {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// Rotated so that the smallest index comes first; the orientation stays.
Triangle rotated(Triangle t) {
  while (t[0] > t[1] || t[0] > t[2]) std::rotate(t.begin(), t.begin() + 1, t.end());
  return t;
}

/// Pairs of triangles with the same corners and opposite senses enclose nothing; rounding to float makes them.
void remove_flaps(TriangleMesh& mesh) {
  struct Keyed {
    Triangle sorted;
    bool forward;
    std::uint32_t index;
  };
  std::vector<Keyed> keyed;
  keyed.reserve(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle t = rotated(mesh.triangles[i]);
    keyed.push_back({{t[0], std::min(t[1], t[2]), std::max(t[1], t[2])}, t[1] < t[2], i});
  }
  std::sort(keyed.begin(), keyed.end(), [](const Keyed& a, const Keyed& b) {
    return a.sorted != b.sorted ? a.sorted < b.sorted : a.index < b.index;
  });
  std::vector<char> dropped(mesh.triangles.size(), 0);
  for (std::size_t i = 0; i < keyed.size();) {
    std::size_t end = i;
    std::vector<std::uint32_t> sides[2];
    for (; end < keyed.size() && keyed[end].sorted == keyed[i].sorted; ++end)
      sides[keyed[end].forward].push_back(keyed[end].index);
    const std::size_t pairs = std::min(sides[0].size(), sides[1].size());
    for (std::size_t p = 0; p < pairs; ++p) dropped[sides[0][p]] = dropped[sides[1][p]] = 1;
    i = end;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    if (!dropped[i]) mesh.triangles[kept++] = mesh.triangles[i];
  mesh.triangles.resize(kept);
}

enum class Fault { boundary, overloaded, inconsistent };

/// ", near (1, 2, 3)": the middle of an edge with this fault, the same for any order of the triangles.
std::string place_of(const TriangleMesh& mesh, Fault fault) {
  std::optional<Vec3> place;
  for_each_edge(edge_uses(mesh.triangles), [&](std::span<const EdgeUse> around) {
    const bool found = fault == Fault::boundary     ? around.size() == 1
                       : fault == Fault::overloaded ? around.size() > 2
                                                    : around.size() == 2 && around[0].forward == around[1].forward;
    if (!found) return;
    const Vec3 middle = 0.5 * (mesh.vertices[around[0].low()] + mesh.vertices[around[0].high()]);
    if (!place || std::lexicographical_compare(middle.data(), middle.data() + 3, place->data(), place->data() + 3))
      place = middle;
  });
  return place ? ", near " + Words(0.05).place(*place) : std::string();
}

}  // namespace

SolidCheck check_solid(const TriangleMesh& mesh) {
  SolidCheck check;
  check.mesh = welded(mesh, 0);
  remove_flaps(check.mesh);
  auto state = topology(check.mesh);
  if (!state.closed() && !check.mesh.empty()) {
    TriangleMesh coarse = welded(mesh, 1e-7 * std::max(mesh.bounds().diagonal(), 1e-9));
    remove_flaps(coarse);
    if (const auto united = topology(coarse); united.closed()) check.mesh = std::move(coarse), state = united;
  }
  auto count = [](std::size_t n, const char* what) {
    return std::to_string(n) + " " + what + (n == 1 ? " edge" : " edges");
  };
  if (check.mesh.empty()) check.faults.push_back("the mesh has no triangles");
  if (state.boundary_edges)
    check.faults.push_back("the surface is open: " + count(state.boundary_edges, "boundary") +
                           place_of(check.mesh, Fault::boundary));
  if (state.nonmanifold_edges)
    check.faults.push_back("the surface is not a 2-manifold: " + count(state.nonmanifold_edges, "overloaded") +
                           place_of(check.mesh, Fault::overloaded));
  if (state.inconsistent_edges)
    check.faults.push_back("neighbouring facets face opposite ways: " +
                           count(state.inconsistent_edges, "inconsistent") + place_of(check.mesh, Fault::inconsistent));
  if (check.faults.empty()) {
    const double v = volume(check.mesh);
    if (v < 0) check.faults.push_back("the solid is inside out: its volume is " + print_number(v) + " mm^3");
    if (v == 0) check.faults.push_back("the solid has no volume");
  }
  check.solid = check.faults.empty();
  return check;
}

TriangleMesh in_canonical_order(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertices.size()), place(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const Vec3 &p = mesh.vertices[a], &q = mesh.vertices[b];
    return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
  });
  TriangleMesh result;
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    place[order[i]] = i;
    result.vertices.push_back(mesh.vertices[order[i]]);
  }
  for (const auto& t : mesh.triangles) result.triangles.push_back(rotated({place[t[0]], place[t[1]], place[t[2]]}));
  std::sort(result.triangles.begin(), result.triangles.end());
  return result;
}

}  // namespace partscribe::verify
