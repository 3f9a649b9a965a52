#include "geometry/mesh/mesh_repair.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/disjoint_sets.h"
#include "core/ensure.h"
#include "geometry/mesh/mesh_facets.h"

namespace partscribe::geometry {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
constexpr std::uint32_t none = ~0u;

/// links[t][k]: the triangle across side k, or none.
using Links = std::vector<Triangle>;

std::size_t drop_degenerate(TriangleMesh& mesh) {
  const std::size_t before = mesh.triangles.size();
  std::vector<std::pair<Triangle, std::uint32_t>> sorted;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    Triangle v = mesh.triangles[t];
    std::sort(v.begin(), v.end());
    if (v[0] != v[1] && v[1] != v[2]) sorted.push_back({v, t});
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::uint8_t> keep(before, 0);
  for (std::size_t i = 0; i < sorted.size(); ++i)
    keep[sorted[i].second] = i == 0 || sorted[i].first != sorted[i - 1].first;
  std::size_t at = 0;
  for (std::size_t t = 0; t < before; ++t)
    if (keep[t]) mesh.triangles[at++] = mesh.triangles[t];
  mesh.triangles.resize(at);
  return before - at;
}

/// Links across edges; where more than two triangles meet, each is paired with the one that bounds the same material.
Links linked(const TriangleMesh& mesh) {
  Links links(mesh.triangles.size(), Triangle{none, none, none});
  auto join = [&](const EdgeUse& a, const EdgeUse& b) {
    links[a.triangle][a.side] = b.triangle;
    links[b.triangle][b.side] = a.triangle;
  };
  std::vector<std::pair<double, const EdgeUse*>> fan;
  for_each_edge(edge_uses(mesh.triangles), [&](std::span<const EdgeUse> around) {
    if (around.size() == 1) return;
    if (around.size() == 2) {
      if (around[0].forward != around[1].forward) join(around[0], around[1]);
      return;
    }
    // Around the directed edge a -> b a forward triangle has its material at smaller angles, so its partner is the
    // backward one just before it.
    const Vec3 a = mesh.vertices[around[0].low()], b = mesh.vertices[around[0].high()];
    const Vec3 axis = (b - a).normalized();
    Vec3 u = Vec3::Zero(), v = Vec3::Zero();
    fan.clear();
    for (const EdgeUse& use : around) {
      const bool first = fan.empty();
      Vec3 d = mesh.vertices[mesh.triangles[use.triangle][(use.side + 2) % 3]] - a;
      d -= axis * axis.dot(d);
      if (first) {
        u = d.normalized();
        v = axis.cross(u);
      }
      double angle = std::atan2(v.dot(d), u.dot(d));
      if (first) angle = 0;
      fan.push_back({angle < 0 ? angle + 6.283185307179586 : angle, &use});
    }
    std::stable_sort(fan.begin(), fan.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
    std::vector<std::uint8_t> used(fan.size(), 0);
    for (std::size_t gap = 1; gap < fan.size(); ++gap)
      for (std::size_t k = 0; k < fan.size(); ++k) {
        const std::size_t other = (k + fan.size() - gap) % fan.size();
        if (used[k] || used[other] || !fan[k].second->forward || fan[other].second->forward) continue;
        used[k] = used[other] = 1;
        join(*fan[k].second, *fan[other].second);
      }
  });
  return links;
}

/// Gives every fan of linked triangles its own vertex; copies move apart by `separation`.
std::size_t split_vertices(TriangleMesh& mesh, const Links& links, double separation) {
  const std::size_t corners = 3 * mesh.triangles.size();
  DisjointSets fans(corners);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t other = links[t][k];
      if (other == none || other < t) continue;
      for (const std::uint32_t end : {k, (k + 1) % 3})
        for (std::uint32_t m = 0; m < 3; ++m)
          if (mesh.triangles[other][m] == mesh.triangles[t][end]) fans.unite(3 * t + end, 3 * other + m);
    }
  std::vector<std::uint32_t> owner(mesh.vertices.size(), none), copy(corners, none);
  std::vector<std::uint8_t> is_split(mesh.vertices.size(), 0);
  std::size_t copies = 0;
  for (std::uint32_t c = 0; c < corners; ++c) {
    const std::uint32_t r = fans.root(c), v = mesh.triangles[c / 3][c % 3];
    if (copy[r] == none) {
      if (owner[v] == none) {
        owner[v] = r;
        copy[r] = v;
      } else {
        copy[r] = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.push_back(Vec3(mesh.vertices[v]));
        is_split[v] = 1;
        is_split.push_back(1);
        ++copies;
      }
    }
  }
  for (std::uint32_t c = 0; c < corners; ++c) mesh.triangles[c / 3][c % 3] = copy[fans.root(c)];
  if (copies > 0 && separation > 0) {
    std::vector<Vec3> sum(mesh.vertices.size(), Vec3::Zero());
    std::vector<double> count(mesh.vertices.size(), 0);
    for (const Triangle& t : mesh.triangles)
      for (int k = 0; k < 3; ++k) {
        if (!is_split[t[k]]) continue;
        sum[t[k]] += mesh.vertices[t[(k + 1) % 3]] + mesh.vertices[t[(k + 2) % 3]];
        count[t[k]] += 2;
      }
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      if (count[v] == 0) continue;
      const Vec3 d = sum[v] / count[v] - mesh.vertices[v];
      if (d.norm() > 0) mesh.vertices[v] += d * std::min(0.25, separation / d.norm());
    }
  }
  return copies;
}

/// Two sheets may share an edge though each runs smoothly past it, with the fans of its ends joined elsewhere: every
/// linked pair but the first gets a vertex of its own in the middle of the edge.
std::size_t split_double_edges(TriangleMesh& mesh, double separation) {
  const std::size_t limit = 3 * mesh.triangles.size();
  std::size_t splits = 0;
  for (bool again = true; again && splits < limit;) {
    again = false;
    const Links links = linked(mesh);
    std::vector<std::uint8_t> touched(mesh.triangles.size(), 0);
    for_each_edge(edge_uses(mesh.triangles), [&](std::span<const EdgeUse> around) {
      if (around.size() <= 2) return;
      again = true;
      bool first = true;
      for (const EdgeUse& use : around) {
        const std::uint32_t t = use.triangle, other = links[t][use.side];
        if (other != none && other < t) continue;
        if (std::exchange(first, false)) continue;
        if (touched[t] || (other != none && touched[other])) continue;
        const Triangle old = mesh.triangles[t];
        const std::uint32_t a = old[use.side], b = old[(use.side + 1) % 3];
        const Vec3 pa = mesh.vertices[a], pb = mesh.vertices[b];
        Vec3 toward = Vec3::Zero();
        const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.push_back(0.5 * (pa + pb));
        for (const std::uint32_t s : {t, other}) {
          if (s == none) continue;
          touched[s] = 1;
          Triangle one = mesh.triangles[s], two = one;
          for (int c = 0; c < 3; ++c) {
            const std::uint32_t v = mesh.triangles[s][c];
            if (v == a) one[c] = middle;
            if (v == b) two[c] = middle;
            if (v != a && v != b) toward += mesh.vertices[v] - mesh.vertices[middle];
          }
          mesh.triangles[s] = one;
          mesh.triangles.push_back(two);
          touched.push_back(1);
        }
        if (separation > 0 && toward.norm() > 0)
          mesh.vertices[middle] += toward * std::min(0.25, separation / toward.norm());
        ++splits;
      }
    });
  }
  return splits;
}

double triangle_area(const TriangleMesh& mesh, const Triangle& t) {
  return 0.5 * (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]).norm();
}

/// For every triangle the number of its component, counted in order of first use.
std::vector<std::uint32_t> components(const std::vector<Triangle>& triangles, const Links& links, std::size_t& count) {
  std::vector<std::uint32_t> label(triangles.size(), none), stack;
  count = 0;
  for (std::uint32_t seed = 0; seed < triangles.size(); ++seed) {
    if (label[seed] != none) continue;
    stack.assign(1, seed);
    label[seed] = static_cast<std::uint32_t>(count);
    while (!stack.empty()) {
      const std::uint32_t t = stack.back();
      stack.pop_back();
      for (const std::uint32_t other : links[t])
        if (other != none && label[other] == none)
          label[other] = static_cast<std::uint32_t>(count), stack.push_back(other);
    }
    ++count;
  }
  return label;
}

/// Boundary loops, each in the direction in which a filling triangle must run through its edges.
std::vector<std::vector<std::uint32_t>> boundary_loops(const TriangleMesh& mesh, const Links& links) {
  std::vector<std::uint32_t> next(mesh.vertices.size(), none);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      if (links[t][k] == none) next[mesh.triangles[t][(k + 1) % 3]] = mesh.triangles[t][k];
  std::vector<std::vector<std::uint32_t>> loops;
  for (std::uint32_t v = 0; v < next.size(); ++v) {
    if (next[v] == none) continue;
    std::vector<std::uint32_t> loop;
    std::uint32_t at = v;
    while (next[at] != none) {
      loop.push_back(at);
      at = std::exchange(next[at], none);
    }
    if (at == v && loop.size() >= 3) loops.push_back(std::move(loop));
  }
  return loops;
}

/// The filling of least (largest bend, area) by dynamic programming [Barequet & Sharir 1995, Liepa 2003]; edges that
/// the mesh has already are avoided. Empty if there is no such filling.
std::vector<Triangle> filling(const TriangleMesh& mesh, const std::vector<std::uint32_t>& loop,
                              const std::vector<std::uint64_t>& edges) {
  const std::size_t n = loop.size();
  std::vector<double> cost(n * n, 0);
  std::vector<std::uint32_t> apex(n * n, none);
  const double forbidden = std::numeric_limits<double>::infinity();
  auto at = [&](std::size_t i) -> const Vec3& { return mesh.vertices[loop[i]]; };
  for (std::size_t length = 2; length < n; ++length)
    for (std::size_t i = 0; i + length < n; ++i) {
      const std::size_t j = i + length;
      double best = forbidden;
      const bool diagonal = !(i == 0 && j == n - 1);
      if (!diagonal || !std::binary_search(edges.begin(), edges.end(), edge_key(loop[i], loop[j])))
        for (std::size_t m = i + 1; m < j; ++m) {
          const double split = cost[i * n + m] + cost[m * n + j];
          if (split >= best) continue;
          const double total = split + 0.5 * (at(m) - at(i)).cross(at(j) - at(i)).norm();
          if (total < best) best = total, apex[i * n + j] = static_cast<std::uint32_t>(m);
        }
      cost[i * n + j] = best;
    }
  std::vector<Triangle> result;
  if (!(cost[n - 1] < forbidden)) return result;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> stack = {{0u, static_cast<std::uint32_t>(n - 1)}};
  while (!stack.empty()) {
    const auto [i, j] = stack.back();
    stack.pop_back();
    if (j - i < 2) continue;
    const std::uint32_t m = apex[i * n + j];
    result.push_back({loop[i], loop[m], loop[j]});
    stack.push_back({i, m});
    stack.push_back({m, j});
  }
  return result;
}

/// A fan round a new vertex in the middle, for loops too long for `filling`.
std::vector<Triangle> fan(TriangleMesh& mesh, const std::vector<std::uint32_t>& loop) {
  Vec3 sum = Vec3::Zero();
  for (const std::uint32_t v : loop) sum += mesh.vertices[v];
  const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(sum / static_cast<double>(loop.size()));
  std::vector<Triangle> result;
  for (std::size_t i = 0; i < loop.size(); ++i) result.push_back({loop[i], loop[(i + 1) % loop.size()], middle});
  return result;
}

/// How far the loop departs from its plane, and how large it is.
std::pair<double, double> bend_and_size(const TriangleMesh& mesh, const std::vector<std::uint32_t>& loop) {
  Vec3 mean = Vec3::Zero();
  Box3 box;
  for (const std::uint32_t v : loop) mean += mesh.vertices[v], box.add(mesh.vertices[v]);
  mean /= static_cast<double>(loop.size());
  Mat3 cov = Mat3::Zero();
  for (const std::uint32_t v : loop) cov += (mesh.vertices[v] - mean) * (mesh.vertices[v] - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(cov);
  double bend = 0;
  for (const std::uint32_t v : loop)
    bend = std::max(bend, std::abs(eigen.eigenvectors().col(0).dot(mesh.vertices[v] - mean)));
  return {bend, box.diagonal()};
}

void fill_holes(TriangleMesh& mesh, const RepairOptions& options, RepairReport& report) {
  const Links links = linked(mesh);
  const auto loops = boundary_loops(mesh, links);
  const double surface = area(mesh), size = mesh.bounds().diagonal();
  std::vector<std::uint64_t> edges;
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) edges.push_back(edge_key(t[k], t[(k + 1) % 3]));
  std::sort(edges.begin(), edges.end());
  for (const auto& loop : loops) {
    const auto [bend, extent] = bend_and_size(mesh, loop);
    const bool wanted = options.fill_all || extent <= options.small_hole * size || bend <= options.flat_hole * extent;
    if (!wanted) {
      ++report.open_holes;
      continue;
    }
    const std::size_t vertices = mesh.vertices.size();
    std::vector<Triangle> patch;
    if (loop.size() <= 600) patch = filling(mesh, loop, edges);
    if (patch.empty()) patch = fan(mesh, loop);
    double patch_area = 0;
    for (const Triangle& t : patch) patch_area += triangle_area(mesh, t);
    if (!options.fill_all && patch_area > options.hole_area * surface) {
      mesh.vertices.resize(vertices);
      ++report.open_holes;
      continue;
    }
    // Later loops must not use these edges again.
    std::vector<std::uint64_t> fresh;
    for (const Triangle& t : patch)
      for (int k = 0; k < 3; ++k) fresh.push_back(edge_key(t[k], t[(k + 1) % 3]));
    std::sort(fresh.begin(), fresh.end());
    std::vector<std::uint64_t> all(edges.size() + fresh.size());
    std::merge(edges.begin(), edges.end(), fresh.begin(), fresh.end(), all.begin());
    edges.swap(all);
    mesh.triangles.insert(mesh.triangles.end(), patch.begin(), patch.end());
    ++report.filled_holes;
    report.filled_area += patch_area;
  }
}

/// Twice the winding share of a closed component around a point: near 0 outside.
double winding(const TriangleMesh& mesh, const std::vector<std::uint32_t>& label, std::uint32_t component,
               const Vec3& p) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (label[t] != component) continue;
    const Vec3 a = mesh.corner(t, 0) - p, b = mesh.corner(t, 1) - p, c = mesh.corner(t, 2) - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / 12.566370614359172;
}

/// Closed components face outward, cavities inward.
void face_outward(TriangleMesh& mesh, RepairReport& report) {
  const Links links = linked(mesh);
  std::size_t count = 0;
  const auto label = components(mesh.triangles, links, count);
  std::vector<double> volumes(count, 0);
  std::vector<std::uint32_t> first(count, none);
  if (mesh.triangles.empty()) return;
  const Vec3 o = mesh.corner(0, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    volumes[label[t]] += (mesh.corner(t, 0) - o).dot((mesh.corner(t, 1) - o).cross(mesh.corner(t, 2) - o)) / 6;
    if (first[label[t]] == none) first[label[t]] = static_cast<std::uint32_t>(t);
  }
  std::vector<std::uint8_t> turn(count, 0);
  for (std::uint32_t c = 0; c < count; ++c) {
    std::size_t depth = 0;
    // Nesting is asked of few components only: beyond that the soup is no assembly of solids and cavities.
    if (count <= 64)
      for (std::uint32_t other = 0; other < count; ++other)
        if (other != c && std::abs(volumes[other]) > std::abs(volumes[c]) &&
            std::abs(winding(mesh, label, other, mesh.corner(first[c], 0))) > 0.5)
          ++depth;
    turn[c] = (volumes[c] < 0) != (depth % 2 == 1);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (turn[label[t]]) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]), ++report.flipped;
}

void drop_unused_vertices(TriangleMesh& mesh) {
  std::vector<std::uint8_t> used(mesh.vertices.size(), 0);
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) used[v] = 1;
  std::vector<std::uint32_t> index(mesh.vertices.size(), none);
  std::uint32_t at = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (used[v]) {
      index[v] = at;
      mesh.vertices[at++] = Vec3(mesh.vertices[v]);
    }
  mesh.vertices.resize(at);
  for (Triangle& t : mesh.triangles)
    for (std::uint32_t& v : t) v = index[v];
}

}  // namespace

RepairReport repair(const TriangleMesh& source, const RepairOptions& options) {
  RepairReport report;
  TriangleMesh& mesh = report.mesh;
  mesh = welded(source, options.weld);
  report.degenerate = source.triangles.size() - mesh.triangles.size();
  report.degenerate += drop_degenerate(mesh);
  report.flipped = orient_facets(mesh);
  Links links = linked(mesh);
  std::size_t count = 0;
  const auto label = components(mesh.triangles, links, count);
  std::vector<double> areas(count, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) areas[label[t]] += triangle_area(mesh, mesh.triangles[t]);
  const double largest = areas.empty() ? 0 : *std::max_element(areas.begin(), areas.end());
  std::vector<std::uint8_t> drop(count, 0);
  for (std::size_t c = 0; c < count; ++c)
    if (areas[c] < options.min_component * largest || areas[c] <= 0)
      drop[c] = 1, ++report.dropped_components, report.dropped_area += areas[c];
  if (report.dropped_components > 0) {
    std::size_t at = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      if (!drop[label[t]]) mesh.triangles[at++] = mesh.triangles[t];
    mesh.triangles.resize(at);
    links = linked(mesh);
  }
  report.split_vertices = split_vertices(mesh, links, options.separation);
  report.split_vertices += split_double_edges(mesh, options.separation);
  fill_holes(mesh, options, report);
  drop_unused_vertices(mesh);
  const MeshTopology result = topology(mesh);
  report.closed = result.closed() && !mesh.triangles.empty();
  if (report.closed) face_outward(mesh, report);
  return report;
}

}  // namespace partscribe::geometry
