#include "geometry/mesh/handles.h"

#include <algorithm>
#include <array>
#include <map>
#include <queue>
#include <tuple>
#include <unordered_map>

#include "core/ensure.h"
#include "geometry/mesh/mesh_neighbours.h"

namespace partscribe::geometry {
namespace {

constexpr std::uint32_t none = no_neighbour;
constexpr std::size_t most_bits = 64;

/// The mesh with a fan of triangles in every loop of its border.
TriangleMesh filled(TriangleMesh mesh) {
  const auto neighbours = mesh_neighbours(mesh);
  std::map<std::uint32_t, std::uint32_t> next;
  for (std::size_t t = 0; t < neighbours.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      if (neighbours[t][k] == none) next[mesh.triangles[t][k]] = mesh.triangles[t][(k + 1) % 3];
  while (!next.empty()) {
    const auto center = static_cast<std::uint32_t>(mesh.vertices.size());
    Vec3 sum = Vec3::Zero();
    std::size_t count = 0;
    for (auto at = next.begin(); at != next.end();) {
      const auto [from, to] = *at;
      next.erase(at);
      mesh.triangles.push_back({to, from, center});
      sum += mesh.vertices[from], ++count;
      at = next.find(to);
    }
    mesh.vertices.emplace_back(sum / double(count));
  }
  return mesh;
}

/// Edges of a closed mesh with the classes of the loops that they are part of: the exclusive or of the labels along a
/// loop is 0 where it bounds a part of the surface, by a tree of edges and a tree of triangles that no edge of the
/// first crosses [Eppstein 2003]. The edges that are left belong to one generator each.
class LabelledEdges {
 public:
  struct Edge {
    std::uint32_t to;
    std::uint64_t label;
    double length;
  };

  explicit LabelledEdges(const TriangleMesh& mesh) : mesh_(mesh), neighbours_(mesh_neighbours(mesh)) {
    id_.resize(mesh.triangles.size());
    for (std::uint32_t t = 0; t < id_.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto other = neighbours_[t][k];
        ensure(other != none, "handles are those of closed meshes");
        if (other < t) continue;
        id_[t][k] = static_cast<std::uint32_t>(ends_.size());
        id_[other][side(other, mesh.triangles[t][(k + 1) % 3])] = id_[t][k];
        ends_.push_back({mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]});
      }
    first_.assign(mesh.vertices.size() + 1, 0);
    for (const auto& [a, b] : ends_) ++first_[a + 1], ++first_[b + 1];
    for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
    label();
    around_.resize(2 * ends_.size());
    auto place = first_;
    for (std::size_t e = 0; e < ends_.size(); ++e) {
      const auto [a, b] = ends_[e];
      const double length = (mesh.vertices[a] - mesh.vertices[b]).norm();
      around_[place[a]++] = {b, labels_[e], length}, around_[place[b]++] = {a, labels_[e], length};
    }
  }

  template <class Visit>
  void around(std::uint32_t vertex, Visit&& visit) const {
    for (std::uint32_t i = first_[vertex]; i < first_[vertex + 1]; ++i) visit(around_[i]);
  }

  /// Every loop that bounds nothing passes one of these.
  std::vector<std::uint32_t> labelled_vertices() const {
    std::vector<std::uint32_t> result;
    for (std::size_t e = 0; e < ends_.size(); ++e)
      if (labels_[e]) result.push_back(ends_[e][0]);
    std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
  }

 private:
  /// The edge of triangle `t` that begins at a vertex.
  std::size_t side(std::uint32_t t, std::uint32_t vertex) const {
    const auto& c = mesh_.triangles[t];
    return std::size_t(std::find(c.begin(), c.end(), vertex) - c.begin());
  }

  void label() {
    std::vector<char> used(ends_.size(), 0);
    {
      std::vector<std::vector<std::pair<std::uint32_t, std::uint32_t>>> out(mesh_.vertices.size());
      for (std::uint32_t e = 0; e < ends_.size(); ++e)
        for (const int k : {0, 1}) out[ends_[e][std::size_t(k)]].emplace_back(ends_[e][std::size_t(1 - k)], e);
      std::vector<char> seen(out.size(), 0);
      for (std::uint32_t root = 0; root < seen.size(); ++root) {
        if (seen[root]) continue;
        std::vector<std::uint32_t> queue = {root};
        seen[root] = 1;
        for (std::size_t q = 0; q < queue.size(); ++q)
          for (const auto& [to, e] : out[queue[q]])
            if (!seen[to]) seen[to] = used[e] = 1, queue.push_back(to);
      }
    }
    struct Step {
      std::uint32_t from = none, edge = none, depth = 0;
    };
    std::vector<Step> tree(id_.size());
    std::vector<char> seen(id_.size(), 0);
    std::vector<std::uint32_t> left;
    std::vector<std::array<std::uint32_t, 2>> sides;
    for (std::uint32_t root = 0; root < seen.size(); ++root) {
      if (seen[root]) continue;
      std::vector<std::uint32_t> queue = {root};
      seen[root] = 1;
      for (std::size_t q = 0; q < queue.size(); ++q) {
        const auto t = queue[q];
        for (std::size_t k = 0; k < 3; ++k) {
          const auto other = neighbours_[t][k], e = id_[t][k];
          if (seen[other] || used[e]) continue;
          seen[other] = used[e] = 1, tree[other] = {t, e, tree[t].depth + 1};
          queue.push_back(other);
        }
      }
    }
    labels_.assign(ends_.size(), 0);
    std::size_t generator = 0;
    for (std::uint32_t t = 0; t < id_.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto e = id_[t][k];
        if (used[e] || generator == most_bits) continue;
        used[e] = 1;
        const std::uint64_t bit = std::uint64_t(1) << generator++;
        labels_[e] ^= bit;
        for (auto a = t, b = neighbours_[t][k]; a != b;) {
          auto& deeper = tree[a].depth > tree[b].depth ? a : b;
          labels_[tree[deeper].edge] ^= bit, deeper = tree[deeper].from;
        }
      }
  }

  const TriangleMesh& mesh_;
  std::vector<std::array<std::uint32_t, 3>> neighbours_, id_;  // beyond, and number of, each edge of each triangle
  std::vector<std::array<std::uint32_t, 2>> ends_;
  std::vector<std::uint64_t> labels_;
  std::vector<std::uint32_t> first_;
  std::vector<Edge> around_;
};

struct Loop {
  double length = 1e300;
  std::uint64_t label = 0;
  std::vector<std::uint32_t> vertices;
};

/// The shortest loop through a vertex that bounds nothing; without vertices where that is longer than `longest`.
Loop shortest_through(const LabelledEdges& edges, std::uint32_t root, double longest) {
  struct Reached {
    double far;
    std::uint32_t from;
    std::uint64_t label;
    bool settled;
  };
  std::unordered_map<std::uint32_t, Reached> reached = {{root, {0, none, 0, false}}};
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  queue.push({0, root});
  Loop best;
  best.length = longest;
  std::uint32_t u = none, v = none;
  while (!queue.empty()) {
    const double far = queue.top().first;
    const std::uint32_t at = queue.top().second;
    queue.pop();
    Reached& here = reached.at(at);
    if (here.settled) continue;
    if (2 * far > best.length) break;
    here.settled = true;
    const std::uint64_t label = here.label;
    edges.around(at, [&](const LabelledEdges::Edge& edge) {
      const auto found = reached.find(edge.to);
      if (found != reached.end() && found->second.settled) {
        const std::uint64_t whole = label ^ found->second.label ^ edge.label;
        const double length = far + found->second.far + edge.length;
        if (whole && length < best.length) best.length = length, best.label = whole, u = at, v = edge.to;
        return;
      }
      const double next = far + edge.length;
      if (2 * next > best.length + 2 * edge.length || (found != reached.end() && found->second.far <= next)) return;
      reached[edge.to] = {next, at, label ^ edge.label, false};
      queue.push({next, edge.to});
    });
  }
  if (u == none) return best;
  const auto back = [&](std::uint32_t from) {
    std::vector<std::uint32_t> path;
    for (; from != none; from = reached.at(from).from) path.push_back(from);
    return path;
  };
  auto left = back(u), right = back(v);
  // What both ways share does not belong to the loop.
  std::uint32_t meet = root;
  while (!left.empty() && !right.empty() && left.back() == right.back())
    meet = left.back(), left.pop_back(), right.pop_back();
  best.length -= 2 * reached.at(meet).far;
  best.vertices = {meet};
  best.vertices.insert(best.vertices.end(), left.rbegin(), left.rend());
  best.vertices.insert(best.vertices.end(), right.begin(), right.end());
  return best;
}

/// Cut along a simple closed loop, both sides filled by fans.
void cut(TriangleMesh& mesh, const std::vector<std::uint32_t>& loop) {
  std::map<std::uint32_t, std::size_t> place;
  for (std::size_t i = 0; i < loop.size(); ++i) place[loop[i]] = i;
  std::vector<std::vector<std::uint32_t>> around(loop.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (const auto v : mesh.triangles[t])
      if (const auto found = place.find(v); found != place.end()) around[found->second].push_back(t);
  // Triangles to the right of the loop get copies of its vertices.
  const auto copies = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto before = mesh.triangles;
  const std::size_t n = loop.size();
  for (std::size_t i = 0; i < n; ++i) {
    const auto from = loop[(i + n - 1) % n], at = loop[i], to = loop[(i + 1) % n];
    std::vector<std::uint32_t> left;
    for (auto edge = to; edge != from;) {
      const auto next = std::find_if(around[i].begin(), around[i].end(), [&](std::uint32_t t) {
        const auto& c = before[t];
        return (c[0] == at && c[1] == edge) || (c[1] == at && c[2] == edge) || (c[2] == at && c[0] == edge);
      });
      ensure(next != around[i].end(), "a loop runs inside of the mesh");
      left.push_back(*next);
      const auto& c = before[*next];
      edge = c[0] == at ? c[2] : c[1] == at ? c[0] : c[1];
    }
    for (const auto t : around[i])
      if (std::find(left.begin(), left.end(), t) == left.end())
        for (auto& v : mesh.triangles[t])
          if (v == at) v = copies + static_cast<std::uint32_t>(i);
  }
  Vec3 middle = Vec3::Zero();
  for (const auto v : loop) middle += mesh.vertices[v] / double(n);
  for (const auto v : loop) mesh.vertices.push_back(Vec3(mesh.vertices[v]));
  const auto centers = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(middle), mesh.vertices.push_back(middle);
  for (std::uint32_t i = 0; i < n; ++i) {
    const auto j = static_cast<std::uint32_t>((i + 1) % n);
    mesh.triangles.push_back({loop[j], loop[i], centers});
    mesh.triangles.push_back({copies + i, copies + j, centers + 1});
  }
}

}  // namespace

std::vector<std::vector<std::uint32_t>> handle_loops(const TriangleMesh& mesh, double longest) {
  const TriangleMesh closed = filled(mesh);
  if (!topology(closed).closed()) return {};
  const LabelledEdges edges(closed);
  std::vector<Loop> loops;
  for (const auto root : edges.labelled_vertices()) {
    Loop loop = shortest_through(edges, root, longest);
    const bool inside = std::all_of(loop.vertices.begin(), loop.vertices.end(),
                                    [&](std::uint32_t v) { return v < mesh.vertices.size(); });
    if (!loop.vertices.empty() && inside) loops.push_back(std::move(loop));
  }
  std::sort(loops.begin(), loops.end(), [](const Loop& a, const Loop& b) {
    return std::tie(a.length, a.vertices) < std::tie(b.length, b.vertices);
  });
  // Loops of independent classes leave the surface in one piece together.
  std::vector<std::uint64_t> basis;
  std::vector<char> taken(closed.vertices.size(), 0);
  std::vector<std::vector<std::uint32_t>> result;
  for (auto& loop : loops) {
    std::uint64_t rest = loop.label;
    for (const std::uint64_t b : basis) rest = std::min(rest, rest ^ b);
    if (rest == 0) continue;
    if (std::any_of(loop.vertices.begin(), loop.vertices.end(), [&](std::uint32_t v) { return taken[v]; })) continue;
    basis.push_back(rest);
    for (const auto v : loop.vertices) {
      taken[v] = 1;
      edges.around(v, [&](const LabelledEdges::Edge& edge) { taken[edge.to] = 1; });
    }
    result.push_back(std::move(loop.vertices));
  }
  return result;
}

TriangleMesh without_handles(TriangleMesh mesh, double longest) {
  for (;;) {
    const auto loops = handle_loops(mesh, longest);
    if (loops.empty()) return mesh;
    for (const auto& loop : loops) cut(mesh, loop);
  }
}

}  // namespace partscribe::geometry
