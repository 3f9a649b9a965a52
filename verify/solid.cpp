#include "verify/solid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>
#include <optional>

#include "core/number.h"
#include "verify/words.h"

namespace partscribe {
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
  struct Use {
    std::uint64_t edge;
    bool forward;
  };
  std::vector<Use> uses;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = t[k], b = t[(k + 1) % 3];
      uses.push_back({std::min(a, b) << 32 | std::max(a, b), a < b});
    }
  std::sort(uses.begin(), uses.end(), [](const Use& a, const Use& b) { return a.edge < b.edge; });
  std::optional<Vec3> place;
  for (std::size_t i = 0; i < uses.size();) {
    std::size_t end = i, forward = 0;
    for (; end < uses.size() && uses[end].edge == uses[i].edge; ++end) forward += uses[end].forward;
    const std::size_t count = end - i;
    const bool found = fault == Fault::boundary     ? count == 1
                       : fault == Fault::overloaded ? count > 2
                                                    : count == 2 && forward != 1;
    if (found) {
      const Vec3 middle = 0.5 * (mesh.vertices[uses[i].edge >> 32] + mesh.vertices[uses[i].edge & 0xffffffffu]);
      if (!place || std::lexicographical_compare(middle.data(), middle.data() + 3, place->data(), place->data() + 3)) place = middle;
    }
    i = end;
  }
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
  auto count = [](std::size_t n, const char* what) { return std::to_string(n) + " " + what + (n == 1 ? " edge" : " edges"); };
  if (check.mesh.empty()) check.faults.push_back("the mesh has no triangles");
  if (state.boundary_edges) check.faults.push_back("the surface is open: " + count(state.boundary_edges, "boundary") +
                           place_of(check.mesh, Fault::boundary));
  if (state.nonmanifold_edges)
    check.faults.push_back("the surface is not a 2-manifold: " + count(state.nonmanifold_edges, "overloaded") +
                           place_of(check.mesh, Fault::overloaded));
  if (state.inconsistent_edges)
    check.faults.push_back("neighbouring facets face opposite ways: " + count(state.inconsistent_edges, "inconsistent") +
                           place_of(check.mesh, Fault::inconsistent));
  if (check.faults.empty()) {
    const double v = volume(check.mesh);
    if (v < 0) check.faults.push_back("the solid is inside out: its volume is " + print_number(v) + " mm^3");
    if (v == 0) check.faults.push_back("the solid has no volume");
  }
  check.solid = check.faults.empty();
  return check;
}

void orient_facets(TriangleMesh& mesh) {
  struct Use {
    std::uint64_t edge;
    std::uint32_t triangle;
    bool forward;
  };
  std::vector<Use> uses;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      uses.push_back({std::min(a, b) << 32 | std::max(a, b), t, a < b});
    }
  std::sort(uses.begin(), uses.end(), [](const Use& a, const Use& b) {
    return a.edge != b.edge ? a.edge < b.edge : a.triangle < b.triangle;
  });
  struct Link {
    std::uint32_t other;
    bool agrees;
  };
  std::vector<std::vector<Link>> links(mesh.triangles.size());
  for (std::size_t i = 0; i < uses.size();) {
    std::size_t end = i;
    while (end < uses.size() && uses[end].edge == uses[i].edge) ++end;
    if (end - i == 2) {
      const bool agrees = uses[i].forward != uses[i + 1].forward;
      links[uses[i].triangle].push_back({uses[i + 1].triangle, agrees});
      links[uses[i + 1].triangle].push_back({uses[i].triangle, agrees});
    }
    i = end;
  }
  std::vector<signed char> turn(mesh.triangles.size(), -1);
  for (std::uint32_t seed = 0; seed < turn.size(); ++seed) {
    if (turn[seed] >= 0) continue;
    std::vector<std::uint32_t> piece = {seed};
    turn[seed] = 0;
    double areas[2] = {0, 0};
    for (std::size_t i = 0; i < piece.size(); ++i) {
      const auto t = piece[i];
      areas[turn[t]] += (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
      for (const auto& link : links[t])
        if (turn[link.other] < 0) {
          turn[link.other] = static_cast<signed char>(link.agrees ? turn[t] : 1 - turn[t]);
          piece.push_back(link.other);
        }
    }
    if (areas[1] > areas[0])
      for (const auto t : piece) turn[t] = static_cast<signed char>(1 - turn[t]);
  }
  for (std::size_t t = 0; t < turn.size(); ++t)
    if (turn[t] == 1) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  if (volume(mesh) < 0 && topology(mesh).closed())
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
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

}  // namespace partscribe
