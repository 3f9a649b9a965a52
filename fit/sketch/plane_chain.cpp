#include "fit/sketch/plane_chain.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "core/disjoint_sets.h"
#include "core/statistics.h"
#include "geometry/points/kd_tree.h"

namespace partscribe::fit {
namespace {

struct Cell {
  double count = 0;
  Vec2 sum = Vec2::Zero();
  Eigen::Matrix2d normals = Eigen::Matrix2d::Zero();
};

using CellKey = std::pair<std::int64_t, std::int64_t>;

/// Main direction of a sum of n n^T.
Vec2 main_direction(const Eigen::Matrix2d& m) {
  const double angle = 0.5 * std::atan2(2 * m(0, 1), m(0, 0) - m(1, 1));
  return {std::cos(angle), std::sin(angle)};
}

/// Nodes: a cell's points averaged; cells that a curve only grazes are given to their neighbours.
std::vector<ChainNode> nodes_of(const std::vector<PlanePoint>& points, const ChainOptions& o) {
  std::map<CellKey, Cell> cells;
  for (const auto& p : points) {
    auto& cell =
        cells[{std::llround(std::floor(p.position.x() / o.cell)), std::llround(std::floor(p.position.y() / o.cell))}];
    cell.count += 1;
    cell.sum += p.position;
    cell.normals += p.normal * p.normal.transpose();
  }
  double typical = 0;
  {
    std::vector<double> counts;
    for (const auto& [key, cell] : cells) counts.push_back(cell.count);
    if (counts.empty()) return {};
    std::sort(counts.begin(), counts.end());
    typical = counts[counts.size() / 2];
  }
  // The densest cells first; a cell whose mean lies close to that of a denser one is the same piece of curve.
  struct Seed {
    CellKey key;
    double count;
  };
  std::vector<Seed> seeds;
  for (const auto& [key, cell] : cells)
    if (cell.count >= std::max(3.0, 0.04 * typical)) seeds.push_back({key, cell.count});
  std::stable_sort(seeds.begin(), seeds.end(), [](const Seed& a, const Seed& b) { return a.count > b.count; });
  std::map<CellKey, std::size_t> owner;
  std::vector<Cell> merged;
  for (const auto& seed : seeds) {
    const Cell& cell = cells[seed.key];
    const Vec2 mean = cell.sum / cell.count;
    std::size_t best = merged.size();
    double nearest = 0.6 * o.cell;
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy) {
        const auto found = owner.find({seed.key.first + dx, seed.key.second + dy});
        if (found == owner.end()) continue;
        const Cell& other = merged[found->second];
        const double distance = (other.sum / other.count - mean).norm();
        if (distance < nearest) nearest = distance, best = found->second;
      }
    owner[seed.key] = best;
    if (best == merged.size())
      merged.push_back(cell);
    else
      merged[best].count += cell.count, merged[best].sum += cell.sum, merged[best].normals += cell.normals;
  }
  std::vector<ChainNode> nodes;
  for (const auto& cell : merged) {
    ChainNode node;
    node.position = cell.sum / cell.count;
    node.weight = cell.count;
    const Eigen::Matrix2d m = cell.normals / cell.count;
    const double mean = 0.5 * (m(0, 0) + m(1, 1)), half = 0.5 * (m(0, 0) - m(1, 1));
    const double spread = std::hypot(half, m(0, 1));
    const Vec2 normal = main_direction(m);
    node.tangent = {-normal.y(), normal.x()};
    node.corner = mean - spread > 0.06;  // variance of the directions: some 14 degrees
    node.sigma = o.noise / std::sqrt(cell.count);
    nodes.push_back(node);
  }
  std::sort(nodes.begin(), nodes.end(), [](const ChainNode& a, const ChainNode& b) {
    return a.position.x() != b.position.x() ? a.position.x() < b.position.x() : a.position.y() < b.position.y();
  });
  return nodes;
}

constexpr std::size_t none = ~std::size_t(0);

/// Points by square cells of a plane.
class PlaneGrid {
 public:
  template <class Point>
  PlaneGrid(const std::vector<Point>& points, double edge) : edge_(edge) {
    for (std::size_t i = 0; i < points.size(); ++i) cells_[key_of(points[i].position)].push_back(i);
  }
  /// Of the cells around a place.
  template <class Visit>
  void near(const Vec2& place, const Visit& visit) const {
    const CellKey key = key_of(place);
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy) {
        const auto found = cells_.find({key.first + dx, key.second + dy});
        if (found == cells_.end()) continue;
        for (const std::size_t i : found->second) visit(i);
      }
  }

 private:
  CellKey key_of(const Vec2& p) const {
    return {std::llround(std::floor(p.x() / edge_)), std::llround(std::floor(p.y() / edge_))};
  }
  double edge_;
  std::map<CellKey, std::vector<std::size_t>> cells_;
};

/// Every how many points are enough for the mean of those within `reach`: of some 500 it is known to 5 % of the noise.
std::size_t stride_for_mean(const std::vector<PlanePoint>& points, double reach) {
  constexpr std::size_t samples = 100, enough = 500;
  const PlaneGrid grid(points, reach);
  std::vector<double> counts;
  for (std::size_t i = 0; i < points.size(); i += points.size() / samples + 1) {
    counts.push_back(0);
    grid.near(points[i].position,
              [&](std::size_t j) { counts.back() += (points[j].position - points[i].position).norm() < reach; });
  }
  return std::max<std::size_t>(static_cast<std::size_t>(median(std::move(counts))) / enough, 1);
}

}  // namespace

std::optional<NormalsMeeting> where_normals_meet(const PlanePoint& a, const PlanePoint& b, double least_sine) {
  const double cross = a.normal.x() * b.normal.y() - a.normal.y() * b.normal.x();
  if (std::abs(cross) < least_sine) return std::nullopt;
  const Vec2 d = b.position - a.position;
  const double s = (d.x() * b.normal.y() - d.y() * b.normal.x()) / cross;
  const Vec2 place = a.position + s * a.normal;
  return NormalsMeeting{place, std::abs(s), (b.position - place).norm()};
}

std::vector<PlanePoint> sharpened(std::vector<PlanePoint> points, double reach, double alone) {
  constexpr int rounds = 3;
  constexpr double alike = 0.85;  // cosine between normals of one side of a corner
  constexpr std::size_t least = 4;
  const std::size_t stride = stride_for_mean(points, reach);
  for (int round = 0; round < rounds; ++round) {
    std::vector<PlanePoint> asked;
    for (std::size_t i = 0; i < points.size(); i += stride) asked.push_back(points[i]);
    const PlaneGrid grid(asked, reach);
    std::vector<PlanePoint> moved = points;
    std::vector<double> support(points.size(), 0);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const PlanePoint& p = points[i];
      const auto of_same_side = [&](const auto& visit) {
        grid.near(p.position, [&](std::size_t j) {
          if ((asked[j].position - p.position).norm() < reach && std::abs(asked[j].normal.dot(p.normal)) > alike)
            visit(asked[j]);
        });
      };
      Eigen::Matrix2d normals = Eigen::Matrix2d::Zero();
      of_same_side(
          [&](const PlanePoint& q) { normals += q.normal * q.normal.transpose(), support[i] += double(stride); });
      if (support[i] == 0) continue;
      const Vec2 n = main_direction(normals);
      std::vector<double> offsets;
      of_same_side([&](const PlanePoint& q) { offsets.push_back(n.dot(q.position - p.position)); });
      moved[i] = {p.position + robust_mean(offsets).mean * n, n};
    }
    const double enough = std::max(double(least), alone * median(support));
    points.clear();
    for (std::size_t i = 0; i < moved.size(); ++i)
      if (support[i] >= enough) points.push_back(moved[i]);
  }
  return points;
}

double length_of(const Chain& chain) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < chain.nodes.size(); ++i)
    sum += (chain.nodes[i + 1].position - chain.nodes[i].position).norm();
  if (chain.closed && chain.nodes.size() > 1)
    sum += (chain.nodes.back().position - chain.nodes.front().position).norm();
  return sum;
}

bool fills_area(const Chain& chain, double cell) {
  constexpr std::size_t around = 24;  // nodes: of a curve they reach 12 cells to either side, of an area 3
  constexpr double close = 4;         // cells
  if (chain.nodes.size() < 4 * around) return false;
  std::vector<Vec3> places;
  for (const auto& node : chain.nodes) places.emplace_back(node.position.x(), node.position.y(), 0);
  const KdTree tree(places);
  std::vector<Neighbour> near;
  std::vector<double> reach;
  for (const Vec3& p : places) tree.nearest(p, around + 1, near), reach.push_back(near.back().sq_distance);
  return std::sqrt(median(std::move(reach))) < close * cell;
}

std::vector<Chain> chains_of(const std::vector<PlanePoint>& points, const ChainOptions& o) {
  const std::vector<ChainNode> nodes = nodes_of(points, o);
  const std::size_t n = nodes.size();
  if (n < 3) return {};
  // Candidate links: near, and not across the curve; cost grows with the turn away from both tangents.
  struct Link {
    double cost;
    std::size_t a, b;
  };
  const double reach = 2.6 * o.cell;
  const PlaneGrid grid(nodes, reach);
  std::vector<Link> links;
  for (std::size_t i = 0; i < n; ++i)
    grid.near(nodes[i].position, [&](std::size_t j) {
      if (j <= i) return;
      const Vec2 d = nodes[j].position - nodes[i].position;
      const double length = d.norm();
      if (length > reach || length <= 0) return;
      const auto along = [&](const ChainNode& node) {
        return node.corner ? 0.8 : std::abs(node.tangent.dot(d)) / length;
      };
      const double a = along(nodes[i]), b = along(nodes[j]);
      if (std::max(a, b) < 0.5) return;
      links.push_back({length * (1 + 2 * (1 - a) + 2 * (1 - b)), i, j});
    });
  std::sort(links.begin(), links.end(), [](const Link& a, const Link& b) {
    return a.cost != b.cost ? a.cost < b.cost : a.a != b.a ? a.a < b.a : a.b < b.b;
  });
  // Cheapest first; each node has one neighbour to either side. A link that would close a ring must close a long one.
  std::vector<std::size_t> next[2];
  next[0].assign(n, none), next[1].assign(n, none);
  DisjointSets chained(n);
  auto free_slot = [&](std::size_t i, const Vec2& d) -> int {
    // The two neighbours of a node lie to different sides of it.
    for (int s = 0; s < 2; ++s)
      if (next[s][i] == none) {
        const std::size_t other = next[1 - s][i];
        if (other == none) return s;
        const Vec2 e = (nodes[other].position - nodes[i].position).normalized();
        return e.dot(d.normalized()) < 0.5 ? s : -1;
      }
    return -1;
  };
  auto connect = [&](std::size_t a, std::size_t b, int sa, int sb) {
    next[sa][a] = b, next[sb][b] = a;
    chained.unite(a, b);
  };
  for (const auto& link : links) {
    const Vec2 d = nodes[link.b].position - nodes[link.a].position;
    const int sa = free_slot(link.a, d), sb = free_slot(link.b, -d);
    if (sa < 0 || sb < 0) continue;
    if (chained.root(link.a) == chained.root(link.b) && chained.size(link.a) < 8) continue;
    connect(link.a, link.b, sa, sb);
  }
  // Short chains are outliers; drop them before gaps are bridged.
  auto ends_of = [&](std::size_t i) { return int(next[0][i] == none) + int(next[1][i] == none); };
  std::vector<char> dropped(n, 0);
  for (std::size_t i = 0; i < n; ++i)
    if (chained.size(i) < o.least) dropped[i] = 1;
  struct Gap {
    double length;
    std::size_t a, b;
  };
  std::vector<std::size_t> ends;
  for (std::size_t i = 0; i < n; ++i)
    if (!dropped[i] && ends_of(i) > 0 && !(o.axis >= 0 && nodes[i].position.x() < o.axis)) ends.push_back(i);
  std::vector<Gap> gaps;
  for (std::size_t i = 0; i < ends.size(); ++i)
    for (std::size_t j = i + 1; j < ends.size(); ++j)
      gaps.push_back({(nodes[ends[i]].position - nodes[ends[j]].position).norm(), ends[i], ends[j]});
  std::sort(gaps.begin(), gaps.end(), [](const Gap& a, const Gap& b) {
    return a.length != b.length ? a.length < b.length : a.a != b.a ? a.a < b.a : a.b < b.b;
  });
  std::vector<std::pair<std::size_t, double>> bridges;
  for (const auto& gap : gaps) {
    if (ends_of(gap.a) == 0 || ends_of(gap.b) == 0) continue;
    const bool same = chained.root(gap.a) == chained.root(gap.b);
    // A ring is closed over a gap only when the gap is small beside the ring; a profile's ends may belong to the axis.
    if (same && gap.length > (o.axis >= 0 ? 6 * o.cell : 0.35 * double(chained.size(gap.a)) * o.cell)) continue;
    if (same && chained.size(gap.a) < 6) continue;
    const int sa = next[0][gap.a] == none ? 0 : 1;
    const int sb = next[0][gap.b] == none ? 0 : 1;
    connect(gap.a, gap.b, sa, gap.a == gap.b ? 1 - sa : sb);
    if (gap.length > 3.5 * o.cell) bridges.emplace_back(gap.a, gap.length);
  }
  std::vector<Chain> chains;
  std::vector<char> used(n, 0);
  auto trace = [&](std::size_t start, bool closed) {
    Chain chain;
    chain.closed = closed;
    std::size_t previous = none, at = start;
    while (at != none && !used[at]) {
      used[at] = 1;
      chain.nodes.push_back(nodes[at]);
      std::size_t to = next[0][at];
      if (to == previous || to == none || used[to]) to = next[1][at];
      if (to != none && (used[to] || to == previous)) to = none;
      previous = at;
      at = to;
    }
    for (const auto& [node, length] : bridges)
      if (chained.root(node) == chained.root(start)) chain.gaps.push_back(length);
    if (chain.nodes.size() >= 3) chains.push_back(std::move(chain));
  };
  for (std::size_t i = 0; i < n; ++i)
    if (!dropped[i] && !used[i] && ends_of(i) > 0) trace(i, false);
  for (std::size_t i = 0; i < n; ++i)
    if (!dropped[i] && !used[i]) trace(i, true);
  std::stable_sort(chains.begin(), chains.end(),
                   [](const Chain& a, const Chain& b) { return length_of(a) > length_of(b); });
  return chains;
}

}  // namespace partscribe::fit
