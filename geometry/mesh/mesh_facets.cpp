#include "geometry/mesh/mesh_facets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/disjoint_sets.h"

namespace partscribe::geometry {

std::vector<Vec3> triangle_normals(const TriangleMesh& mesh) {
  std::vector<Vec3> normals(mesh.triangles.size());
  for (std::size_t t = 0; t < normals.size(); ++t) normals[t] = triangle_normal(mesh, t);
  return normals;
}

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 | std::max(a, b);
}

std::vector<EdgeUse> edge_uses(std::span<const std::array<std::uint32_t, 3>> triangles) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::uint8_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      uses.push_back({edge_key(a, b), t, k, a < b});
    }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return a.key != b.key ? a.key < b.key : a.triangle < b.triangle;
  });
  return uses;
}

std::vector<double> chord_depths(const TriangleMesh& mesh) {
  constexpr double sharp = 0.7;
  const std::vector<Vec3> normals = triangle_normals(mesh);
  std::vector<double> depth(mesh.triangles.size(), 0);
  for_each_edge(edge_uses(mesh.triangles), [&](std::span<const EdgeUse> around) {
    if (around.size() != 2) return;
    const Vec3 &a = normals[around[0].triangle], &b = normals[around[1].triangle];
    const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
    if (angle > sharp) return;
    for (const EdgeUse& use : around) {
      const Vec3 from = mesh.corner(use.triangle, use.side),
                 along = mesh.corner(use.triangle, (use.side + 1) % 3) - from;
      const Vec3 across = mesh.corner(use.triangle, (use.side + 2) % 3) - from;
      if (!(along.norm() > 0)) continue;
      depth[use.triangle] += along.cross(across).norm() / along.norm() * angle / 8;
    }
  });
  return depth;
}

std::size_t orient_facets(TriangleMesh& mesh) {
  constexpr std::uint32_t none = ~0u;
  struct Link {
    std::uint32_t other = none;
    bool same = false;  // both run through the edge in one direction
  };
  std::vector<std::array<Link, 3>> links(mesh.triangles.size());
  for_each_edge(edge_uses(mesh.triangles), [&](std::span<const EdgeUse> around) {
    if (around.size() != 2) return;
    const bool same = around[0].forward == around[1].forward;
    links[around[0].triangle][around[0].side] = {around[1].triangle, same};
    links[around[1].triangle][around[1].side] = {around[0].triangle, same};
  });
  std::vector<std::int8_t> turned(mesh.triangles.size(), -1);
  std::vector<std::uint32_t> piece;
  std::size_t count = 0;
  for (std::uint32_t seed = 0; seed < turned.size(); ++seed) {
    if (turned[seed] >= 0) continue;
    piece.assign(1, seed);
    turned[seed] = 0;
    double areas[2] = {0, 0};
    for (std::size_t at = 0; at < piece.size(); ++at) {
      const std::uint32_t t = piece[at];
      areas[turned[t]] += (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
      for (const Link& link : links[t])
        if (link.other != none && turned[link.other] < 0) {
          turned[link.other] = static_cast<std::int8_t>(turned[t] ^ static_cast<std::int8_t>(link.same));
          piece.push_back(link.other);
        }
    }
    const bool other_way = areas[1] > areas[0];
    for (const std::uint32_t t : piece)
      if ((turned[t] != 0) != other_way) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]), ++count;
  }
  return count;
}

bool turn_outward(TriangleMesh& mesh) {
  if (!topology(mesh).closed() || volume(mesh) >= 0) return false;
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return true;
}

std::size_t flat_facets(const TriangleMesh& mesh) {
  std::size_t count = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 1) - mesh.corner(t, 0), b = mesh.corner(t, 2) - mesh.corner(t, 0);
    const double length = std::max({a.norm(), b.norm(), (b - a).norm()}), far = mesh.corner(t, 0).cwiseAbs().maxCoeff();
    count += a.cross(b).norm() <= 4e-16 * length * std::max(length, far);  // no more than rounding
  }
  return count;
}

MeshPieces pieces_of(const TriangleMesh& mesh) {
  DisjointSets sets(mesh.vertices.size());
  for (const auto& t : mesh.triangles) sets.unite(t[0], t[1]), sets.unite(t[0], t[2]);
  constexpr std::uint32_t none = ~0u;
  std::vector<std::uint32_t> number(mesh.vertices.size(), none);
  for (const auto& t : mesh.triangles) number[sets.root(t[0])] = 0;
  std::uint32_t count = 0;
  for (auto& n : number)
    if (n != none) n = count++;
  MeshPieces pieces;
  pieces.of.reserve(mesh.triangles.size());
  pieces.area.assign(count, 0), pieces.volume.assign(count, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t root = sets.root(mesh.triangles[t][0]), piece = number[root];
    const Vec3 o = mesh.vertices[root];  // near the piece: far from the origin nothing cancels
    const Vec3 a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
    pieces.of.push_back(piece);
    pieces.area[piece] += 0.5 * (b - a).cross(c - a).norm();
    pieces.volume[piece] += (a - o).dot((b - o).cross(c - o)) / 6;
  }
  return pieces;
}

}  // namespace partscribe::geometry
