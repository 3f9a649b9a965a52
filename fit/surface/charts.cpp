#include "fit/surface/charts.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <queue>
#include <set>

#include "geometry/mesh/mesh_neighbours.h"
#include "geometry/mesh/mesh_part.h"

namespace partscribe::fit {
namespace {

constexpr double widest = 0.57;        // cosine of the angle between a triangle's normal and its chart's
constexpr double widest_small = 0.25;  // the same for a small chart and the one it joins
constexpr double most_wide = 0.01;     // share of a chart's area that may be steeper
constexpr double least_share = 5e-4;   // of the area: what creases cut off and is smaller is noise
constexpr int most_charts = 400;
constexpr std::uint32_t none = no_neighbour;

/// Triangles, their areas, smoothed normals and neighbours.
class Surface {
 public:
  explicit Surface(const TriangleMesh& mesh) : mesh_(mesh) {
    const std::size_t n = mesh.triangles.size();
    neighbours = mesh_neighbours(mesh);
    open = neighbours;
    areas.resize(n), normals.resize(n);
    for (std::size_t t = 0; t < n; ++t) {
      const Vec3 cross = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
      areas[t] = 0.5 * cross.norm(), normals[t] = areas[t] > 0 ? Vec3(cross.normalized()) : Vec3::Zero();
    }
    close_creases();
    // Noise tilts single triangles: each with its neighbours, twice.
    for (int round = 0; round < 2; ++round) {
      std::vector<Vec3> next(n);
      for (std::size_t t = 0; t < n; ++t) {
        Vec3 sum = areas[t] * normals[t];
        for (const auto other : open[t])
          if (other != none) sum += areas[other] * normals[other];
        next[t] = sum.norm() > 0 ? Vec3(sum.normalized()) : normals[t];
      }
      normals = std::move(next);
    }
  }

  std::uint32_t from(std::uint32_t t, int k) const { return mesh_.triangles[t][std::size_t(k)]; }
  std::uint32_t to(std::uint32_t t, int k) const { return mesh_.triangles[t][std::size_t((k + 1) % 3)]; }
  std::uint32_t size() const { return static_cast<std::uint32_t>(areas.size()); }
  Vec3 middle(std::uint32_t t) const { return (mesh_.corner(t, 0) + mesh_.corner(t, 1) + mesh_.corner(t, 2)) / 3; }
  const TriangleMesh& mesh() const { return mesh_; }

  std::vector<std::array<std::uint32_t, 3>> neighbours;  // beyond the edge from corner k to the next
  std::vector<std::array<std::uint32_t, 3>> open;        // the same, but none beyond a crease
  std::vector<double> areas;
  std::vector<Vec3> normals;

 private:
  /// No chart grows over a crease. Those round little surface are noise.
  void close_creases() {
    const auto sharp = [&](std::uint32_t t, std::size_t k) {
      const auto other = neighbours[t][k];
      return other != none && normals[t].dot(normals[other]) < sharp_cosine;
    };
    for (std::uint32_t t = 0; t < size(); ++t)
      for (std::size_t k = 0; k < 3; ++k)
        if (sharp(t, k)) open[t][k] = none;
    double all = 0;
    for (const double a : areas) all += a;
    for (const auto& piece : connected_pieces(open)) {
      double piece_area = 0;
      for (const auto t : piece) piece_area += areas[t];
      if (piece_area > least_share * all) continue;
      for (const auto t : piece)
        for (std::size_t k = 0; k < 3; ++k) {
          const auto other = open[t][k] = neighbours[t][k];
          if (other == none) continue;
          for (std::size_t back = 0; back < 3; ++back)
            if (neighbours[other][back] == t) open[other][back] = t;
        }
    }
  }

  const TriangleMesh& mesh_;
};

/// Grows charts from seed triangles, those first whose normals are nearest to the chart's.
std::vector<int> grown(const Surface& surface, const std::vector<std::uint32_t>& seeds,
                       const std::vector<Vec3>& directions) {
  struct Entry {
    double error;
    std::uint32_t triangle;
    int chart;
    bool operator<(const Entry& o) const {
      if (error != o.error) return error > o.error;
      return triangle != o.triangle ? triangle > o.triangle : chart > o.chart;
    }
  };
  std::vector<int> of(surface.size(), -1);
  std::priority_queue<Entry> queue;
  const auto enter = [&](std::uint32_t t, int chart) {
    if (t == none || of[t] >= 0) return;
    queue.push({surface.areas[t] * (surface.normals[t] - directions[std::size_t(chart)]).squaredNorm(), t, chart});
  };
  for (std::size_t s = 0; s < seeds.size(); ++s) queue.push({-1, seeds[s], static_cast<int>(s)});
  while (!queue.empty()) {
    const Entry best = queue.top();
    queue.pop();
    if (of[best.triangle] >= 0) continue;
    of[best.triangle] = best.chart;
    for (const auto other : surface.open[best.triangle]) enter(other, best.chart);
  }
  return of;
}

std::vector<Vec3> mean_normals(const Surface& surface, const std::vector<int>& of, std::size_t count) {
  std::vector<Vec3> result(count, Vec3::Zero());
  for (std::uint32_t t = 0; t < surface.size(); ++t)
    if (of[t] >= 0) result[std::size_t(of[t])] += surface.areas[t] * surface.normals[t];
  for (Vec3& n : result) n = n.norm() > 0 ? Vec3(n.normalized()) : Vec3::UnitZ();
  return result;
}

/// In each chart the triangle whose normal is nearest to the chart's (`best`) or farthest from it.
std::vector<std::uint32_t> extremes(const Surface& surface, const std::vector<int>& of,
                                    const std::vector<Vec3>& directions, bool best) {
  std::vector<std::uint32_t> result(directions.size(), none);
  std::vector<double> value(directions.size(), -1e300);
  for (std::uint32_t t = 0; t < surface.size(); ++t) {
    if (of[t] < 0) continue;
    const auto c = std::size_t(of[t]);
    const double now = (best ? 1 : -1) * surface.normals[t].dot(directions[c]);
    if (now > value[c]) value[c] = now, result[c] = t;
  }
  return result;
}

/// Share of the area of each chart that turns away from its direction.
std::vector<double> wide_shares(const Surface& surface, const std::vector<int>& of,
                                const std::vector<Vec3>& directions) {
  std::vector<double> all(directions.size(), 0), wide(directions.size(), 0);
  for (std::uint32_t t = 0; t < surface.size(); ++t) {
    if (of[t] < 0) continue;
    const auto c = std::size_t(of[t]);
    all[c] += surface.areas[t];
    if (surface.normals[t].dot(directions[c]) < widest) wide[c] += surface.areas[t];
  }
  for (std::size_t c = 0; c < all.size(); ++c) wide[c] = all[c] > 0 ? wide[c] / all[c] : 0;
  return wide;
}

/// Charts around seeds, settled: grown, their normals found anew, grown again.
std::vector<int> settled(const Surface& surface, std::vector<std::uint32_t>& seeds, int rounds) {
  std::vector<Vec3> directions;
  for (const auto s : seeds) directions.push_back(surface.normals[s]);
  std::vector<int> of;
  for (int round = 0; round < rounds; ++round) {
    of = grown(surface, seeds, directions);
    directions = mean_normals(surface, of, seeds.size());
    seeds = extremes(surface, of, directions, true);
  }
  return of;
}

/// Pairs of neighbouring charts become one as long as that one lies open, those first whose normals are most alike.
/// Small ones join another even where that is steeper, or beyond a crease.
void unite(const Surface& surface, std::vector<int>& of, std::size_t count, double small) {
  for (;;) {
    struct Pair {
      int edges = 0, open = 0;  // open: no crease
    };
    std::map<std::pair<int, int>, Pair> pairs;
    for (std::uint32_t t = 0; t < surface.size(); ++t)
      for (const auto other : surface.neighbours[t])
        if (other != none && of[t] < of[other]) {
          Pair& pair = pairs[{of[t], of[other]}];
          const auto& open = surface.open[t];
          pair.open += std::find(open.begin(), open.end(), other) != open.end(), ++pair.edges;
        }
    std::vector<Vec3> sums(count, Vec3::Zero());
    std::vector<double> areas(count, 0);
    for (std::uint32_t t = 0; t < surface.size(); ++t) {
      sums[std::size_t(of[t])] += surface.areas[t] * surface.normals[t];
      areas[std::size_t(of[t])] += surface.areas[t];
    }
    std::vector<std::vector<std::uint32_t>> members(count);
    for (std::uint32_t t = 0; t < surface.size(); ++t) members[std::size_t(of[t])].push_back(t);
    std::pair<int, int> best{-1, -1};
    double least = 1e300;
    for (const auto& [pair, p] : pairs) {
      const auto a = std::size_t(pair.first), b = std::size_t(pair.second);
      const bool either_small = std::min(areas[a], areas[b]) < small;
      if (2 * p.open < p.edges && !either_small) continue;
      const Vec3 direction = (sums[a] + sums[b]).normalized();
      // What is spread about the common normal: area less the length of the sum.
      const double spread = areas[a] + areas[b] - (sums[a] + sums[b]).norm();
      if (spread >= least) continue;
      double wide = 0;
      for (const auto c : {a, b})
        for (const auto t : members[c])
          if (surface.normals[t].dot(direction) < (either_small ? widest_small : widest + 0.03))
            wide += surface.areas[t];
      if (wide > 0.5 * most_wide * (areas[a] + areas[b])) continue;
      least = spread, best = pair;
    }
    if (best.first < 0) return;
    for (int& c : of)
      if (c == best.second) c = best.first;
  }
}

/// Borders made shorter, pieces cut off and charts that touch themselves at a vertex mended.
class Cleaner {
 public:
  Cleaner(const Surface& surface, std::vector<int>& of) : surface_(surface), of_(of) {
    around_.resize(surface.mesh().vertices.size());
    for (std::uint32_t t = 0; t < surface.size(); ++t)
      for (int k = 0; k < 3; ++k) around_[surface.from(t, k)].push_back(t);
  }

  bool clean() {
    for (int round = 0; round < 20 && shorten(); ++round) {
    }
    for (int round = 0; round < 20; ++round)
      if (!join_pieces() && !mend_touching()) return true;
    return false;
  }

 private:
  /// All triangles round a vertex join one chart where that makes borders shorter and none of them is steep there.
  bool shorten() {
    const std::size_t count = std::size_t(*std::max_element(of_.begin(), of_.end())) + 1;
    const auto directions = mean_normals(surface_, of_, count);
    bool changed = false;
    for (std::uint32_t v = 0; v < around_.size(); ++v) {
      std::map<int, double> length;  // of borders, if all became this chart
      for (const auto t : around_[v]) length[of_[t]] = 0;
      if (length.size() < 2 || at_crease(v)) continue;
      double now = 0;
      for (const auto t : around_[v])
        for (int k = 0; k < 3; ++k) {
          const auto other = surface_.neighbours[t][std::size_t(k)];
          if (other == none) continue;
          const double edge = (surface_.mesh().corner(t, k) - surface_.mesh().corner(t, (k + 1) % 3)).norm();
          const bool spoke = surface_.from(t, k) == v || surface_.to(t, k) == v;
          if (of_[other] != of_[t]) now += spoke ? 0.5 * edge : edge;
          if (spoke) continue;
          for (auto& [chart, sum] : length)
            if (of_[other] != chart) sum += edge;
        }
      const auto best = std::min_element(length.begin(), length.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
      if (best->second > 0.95 * now) continue;
      bool open = true;
      for (const auto t : around_[v])
        open = open &&
               (of_[t] == best->first || surface_.normals[t].dot(directions[std::size_t(best->first)]) > widest - 0.07);
      if (!open) continue;
      for (const auto t : around_[v]) of_[t] = best->first;
      changed = true;
    }
    return changed;
  }

  /// Does one crease run straight through a vertex? Others end there, or are noise.
  bool at_crease(std::uint32_t v) const {
    std::vector<Vec3> out;
    for (const auto t : around_[v])
      for (int k = 0; k < 3; ++k)
        if (surface_.from(t, k) == v && surface_.open[t][std::size_t(k)] != surface_.neighbours[t][std::size_t(k)])
          out.push_back((surface_.mesh().vertices[surface_.to(t, k)] - surface_.mesh().vertices[v]).normalized());
    return out.size() == 2 && out[0].dot(out[1]) < -0.7;
  }

  /// Each chart keeps its largest connected piece; the others join the chart they share the longest border with.
  bool join_pieces() {
    auto within = surface_.neighbours;
    for (std::uint32_t t = 0; t < surface_.size(); ++t)
      for (auto& other : within[t])
        if (other != none && of_[other] != of_[t]) other = none;
    const auto pieces = connected_pieces(within);
    const auto size = [&](const auto& members) {
      double sum = 0;
      for (const auto t : members) sum += surface_.areas[t];
      return sum;
    };
    std::map<int, std::pair<double, std::size_t>> largest;
    for (std::size_t p = 0; p < pieces.size(); ++p) {
      const double s = size(pieces[p]);
      auto& best = largest.try_emplace(of_[pieces[p][0]], -1.0, 0).first->second;
      if (s > best.first) best = {s, p};
    }
    bool changed = false;
    for (std::size_t p = 0; p < pieces.size(); ++p) {
      const int chart = of_[pieces[p][0]];
      if (largest[chart].second == p) continue;
      std::map<int, double> beside;
      for (const auto t : pieces[p])
        for (int k = 0; k < 3; ++k)
          if (const auto other = surface_.neighbours[t][std::size_t(k)]; other != none && of_[other] != chart)
            beside[of_[other]] += (surface_.mesh().corner(t, k) - surface_.mesh().corner(t, (k + 1) % 3)).norm();
      if (beside.empty()) continue;
      const auto to = std::max_element(beside.begin(), beside.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
      for (const auto t : pieces[p]) of_[t] = to->first;
      changed = true;
    }
    return changed;
  }

  /// Where a chart has two fans of triangles at a vertex, the smaller one goes to the chart beside it.
  bool mend_touching() {
    bool changed = false;
    for (std::uint32_t v = 0; v < around_.size(); ++v) {
      const auto& ring = around_[v];
      std::map<int, std::vector<std::vector<std::uint32_t>>> fans;
      std::vector<char> seen(ring.size(), 0);
      const auto at = [&](std::uint32_t t) {
        return std::size_t(std::find(ring.begin(), ring.end(), t) - ring.begin());
      };
      for (std::size_t i = 0; i < ring.size(); ++i) {
        if (seen[i]) continue;
        auto& fan = fans[of_[ring[i]]].emplace_back(1, ring[i]);
        seen[i] = 1;
        for (std::size_t f = 0; f < fan.size(); ++f)
          for (const auto other : surface_.neighbours[fan[f]]) {
            const std::size_t place = other == none ? ring.size() : at(other);
            if (place < ring.size() && !seen[place] && of_[other] == of_[fan[0]]) seen[place] = 1, fan.push_back(other);
          }
      }
      for (auto& [chart, list] : fans) {
        if (list.size() < 2) continue;
        std::stable_sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
        for (std::size_t f = 1; f < list.size(); ++f) {
          int to = -1;
          for (const auto t : list[f])
            for (const auto other : surface_.neighbours[t])
              if (other != none && at(other) < ring.size() && of_[other] != chart) to = of_[other];
          if (to < 0) continue;
          for (const auto t : list[f]) of_[t] = to;
          changed = true;
        }
        if (changed) break;  // the fans have changed
      }
    }
    return changed;
  }

  const Surface& surface_;
  std::vector<int>& of_;
  std::vector<std::vector<std::uint32_t>> around_;  // triangles of each vertex
};

/// Where charts meet, traced from node to node.
std::vector<ChartBorder> traced(const Surface& surface, const std::vector<int>& of) {
  // Half edges whose triangle belongs to another chart than the one beyond; each border once, by its lower chart.
  struct Half {
    std::uint32_t to;
    int left, right;
  };
  std::map<std::uint32_t, std::vector<Half>> out;
  std::map<std::uint32_t, int> degree;
  for (std::uint32_t t = 0; t < surface.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto other = surface.neighbours[t][std::size_t(k)];
      const int right = other == none ? -1 : of[other];
      if (right == of[t]) continue;
      if (right >= 0 && right < of[t]) continue;
      out[surface.from(t, k)].push_back({surface.to(t, k), of[t], right});
      degree[surface.from(t, k)] += 1, degree[surface.to(t, k)] += 1;
    }
  std::vector<ChartBorder> result;
  const auto take = [&](std::uint32_t vertex, int left, int right) -> std::uint32_t {
    const auto found = out.find(vertex);
    if (found == out.end()) return none;
    auto& list = found->second;
    for (auto half = list.begin(); half != list.end(); ++half) {
      if (half->left != left || half->right != right) continue;
      const auto to = half->to;
      list.erase(half);
      return to;
    }
    return none;
  };
  const auto trace = [&](std::uint32_t start) {
    while (!out[start].empty()) {
      const Half first = out[start].front();
      ChartBorder border{first.left, first.right, false, {start}};
      for (auto at = take(start, first.left, first.right); at != none;) {
        border.vertices.push_back(at);
        if (at == start || degree[at] != 2) break;
        at = take(at, first.left, first.right);
      }
      result.push_back(std::move(border));
    }
  };
  std::vector<std::uint32_t> starts;
  for (const auto& [vertex, list] : out)
    if (degree[vertex] != 2) starts.push_back(vertex);
  for (const auto vertex : starts) trace(vertex);
  // What is left are closed borders.
  for (auto& [vertex, list] : out)
    if (!list.empty()) trace(vertex);
  std::set<std::pair<std::uint32_t, std::uint32_t>> creases;
  for (std::uint32_t t = 0; t < surface.size(); ++t)
    for (int k = 0; k < 3; ++k)
      if (surface.open[t][std::size_t(k)] != surface.neighbours[t][std::size_t(k)])
        creases.insert({surface.from(t, k), surface.to(t, k)});
  for (ChartBorder& border : result) {
    double sharp = 0, all = 0;
    for (std::size_t i = 1; i < border.vertices.size(); ++i) {
      const auto a = border.vertices[i - 1], b = border.vertices[i];
      const double length = (surface.mesh().vertices[a] - surface.mesh().vertices[b]).norm();
      all += length;
      if (creases.count({a, b})) sharp += length;
    }
    border.crease = sharp > 0.5 * all;
  }
  return result;
}

Charts numbered(const Surface& surface, std::vector<int> of) {
  Charts charts;
  std::map<int, int> number;
  for (int& c : of) c = number.try_emplace(c, static_cast<int>(number.size())).first->second;
  charts.count = static_cast<int>(number.size());
  charts.borders = traced(surface, of);
  charts.of = std::move(of);
  return charts;
}

}  // namespace

Charts charts_of(const TriangleMesh& mesh, double small, Context& context) {
  const Surface surface(mesh);
  std::vector<std::uint32_t> seeds;
  for (const auto& piece : connected_pieces(surface.open)) seeds.push_back(piece.front());
  std::vector<int> of;
  for (int round = 0; round < 60 && !context.cancelled; ++round) {
    of = settled(surface, seeds, 5);
    const auto directions = mean_normals(surface, of, seeds.size());
    const auto wide = wide_shares(surface, of, directions);
    const auto worst = extremes(surface, of, directions, false);
    const std::size_t before = seeds.size();
    for (std::size_t c = 0; c < before; ++c)
      if (wide[c] > most_wide) seeds.push_back(worst[c]);
    if (seeds.size() == before || seeds.size() > most_charts) break;
  }
  unite(surface, of, seeds.size(), small);
  if (!Cleaner(surface, of).clean()) return {};
  return numbered(surface, std::move(of));
}

Charts with_chart_split(const TriangleMesh& mesh, const Charts& charts, int chart) {
  const Surface surface(mesh);
  // Two seeds as far apart as places go, along the longest direction of the chart.
  Vec3 mean = Vec3::Zero();
  double all = 0;
  for (std::uint32_t t = 0; t < surface.size(); ++t)
    if (charts.of[t] == chart) mean += surface.areas[t] * surface.middle(t), all += surface.areas[t];
  mean /= std::max(all, 1e-300);
  Mat3 spread = Mat3::Zero();
  for (std::uint32_t t = 0; t < surface.size(); ++t)
    if (charts.of[t] == chart)
      spread += surface.areas[t] * (surface.middle(t) - mean) * (surface.middle(t) - mean).transpose();
  const Vec3 along = Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvectors().col(2);
  std::vector<int> of = charts.of;
  for (std::uint32_t t = 0; t < surface.size(); ++t)
    if (of[t] == chart && (surface.middle(t) - mean).dot(along) > 0) of[t] = charts.count;
  if (!Cleaner(surface, of).clean()) return {};
  return numbered(surface, std::move(of));
}

}  // namespace partscribe::fit
