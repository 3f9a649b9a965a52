#include "geometry/mesh/decimate.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <queue>

#include "core/ensure.h"
#include "core/parallel.h"
#include "geometry/decompose.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/mesh/self_intersection.h"
#include "geometry/points/kd_tree.h"
#include "geometry/points/thin.h"

namespace partscribe::geometry {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// x^T a x + 2 b.x + c: the weighted sum of squared distances from planes [Garland & Heckbert 1997].
struct Quadric {
  Mat3 a = Mat3::Zero();
  Vec3 b = Vec3::Zero();
  double c = 0;
  void add_plane(const Vec3& normal, const Vec3& point, double weight) {
    const double d = -normal.dot(point);
    a += weight * normal * normal.transpose();
    b += weight * d * normal;
    c += weight * d * d;
  }
  Quadric& operator+=(const Quadric& other) {
    a += other.a, b += other.b, c += other.c;
    return *this;
  }
  double at(const Vec3& x) const { return std::max(0.0, x.dot(a * x) + 2 * b.dot(x) + c); }
};

struct Candidate {
  double cost;
  std::uint32_t a, b, stamp_a, stamp_b;
  /// The queue delivers the cheapest first; equal costs in order of their vertices.
  bool operator<(const Candidate& other) const {
    if (cost != other.cost) return cost > other.cost;
    return a != other.a ? a > other.a : b > other.b;
  }
};

class Decimator {
 public:
  Decimator(const TriangleMesh& mesh, const DecimateOptions& options, Context& context)
      : mesh_(mesh), options_(options), context_(context), original_(mesh), origin_(mesh.bounds().center()) {
    const std::size_t n = mesh.vertices.size(), m = mesh.triangles.size();
    points_ = mesh.vertices;
    triangles_ = mesh.triangles;
    alive_.assign(m, 1), seen_.assign(m, 0);
    fans_.resize(n);
    quadrics_.resize(n);
    stamps_.assign(n, 0);
    border_.assign(n, 0);
    samples_of_.resize(m);
    left_ = m;
    for (std::uint32_t t = 0; t < m; ++t)
      for (const std::uint32_t v : triangles_[t]) fans_[v].push_back(t);
    double edge_sum = 0;
    for (std::uint32_t t = 0; t < m; ++t) {
      const Vec3 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
      edge_sum += (b - a).norm() + (c - b).norm() + (a - c).norm();
      const Vec3 n2 = (b - a).cross(c - a);
      const double twice = n2.norm();
      if (twice > 0)
        for (const std::uint32_t v : triangles_[t]) quadrics_[v].add_plane(n2 / twice, a - origin_, twice / 6);
    }
    // Coarse meshes bend more from facet to facet, so that they are looked at more closely.
    if (m > 0) probe_ = (m <= 150000 ? 0.7 : 1.5) * edge_sum / (3.0 * static_cast<double>(m));
    // Samples of the original surface; each belongs to a triangle that is near enough to it.
    std::vector<std::uint32_t> sampled;
    for (std::uint32_t v = 0; v < n; ++v)
      if (!fans_[v].empty())
        sampled.push_back(v), owners_.push_back(fans_[v].front()), add_sample(fans_[v].front(), points_[v]);
    for (std::uint32_t t = 0; t < m; ++t) {
      add_sample(t, (corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3);
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
        const bool alone = edge_triangles(a, b) == 1;
        if (alone) {
          border_[a] = border_[b] = 1;
          // A wall on the border edge keeps it in place.
          const Vec3 e = points_[b] - points_[a];
          const Vec3 wall = e.cross(triangle_normal(mesh_, t));
          if (wall.norm() > 0)
            for (const std::uint32_t v : {a, b})
              quadrics_[v].add_plane(wall.normalized(), points_[a] - origin_, 2 * e.squaredNorm());
        }
        if (alone || (a < b && m <= 150000)) add_sample(t, 0.5 * (points_[a] + points_[b]));
      }
    }
    if (m > 0) find_narrow_places(sampled, edge_sum / (3.0 * static_cast<double>(m)));
  }

  TriangleMesh run() {
    const std::size_t start = left_;
    for (int pass = 0; pass < options_.passes && !done(); ++pass) {
      const std::size_t before = left_;
      fill_queue();
      std::size_t step = 0;
      while (!queue_.empty() && !done()) {
        const Candidate next = queue_.top();
        queue_.pop();
        if (stamps_[next.a] != next.stamp_a || stamps_[next.b] != next.stamp_b) continue;
        try_collapse(next.a, next.b);
        if (++step % 4096 == 0) {
          if (context_.cancelled) break;
          context_.report("decimate", 1 - static_cast<double>(left_) / static_cast<double>(start));
        }
      }
      if (context_.cancelled || before - left_ < before / 100 + 1) break;
    }
    return result();
  }

 private:
  Vec3 corner(std::uint32_t t, int k) const { return points_[triangles_[t][k]]; }
  bool done() const { return options_.target_triangles > 0 && left_ <= options_.target_triangles; }

  void add_sample(std::uint32_t t, const Vec3& p) {
    samples_of_[t].push_back(static_cast<std::uint32_t>(samples_.size()));
    samples_.push_back(p);
  }

  /// Notes for the first samples, those at the vertices `sampled`, which others of another sheet or of the other side
  /// of an edge lie so near that decimated surfaces could meet there. `edge`: mm, the mean length.
  void find_narrow_places(const std::vector<std::uint32_t>& sampled, double edge) {
    std::vector<Vec3> all;
    for (const std::uint32_t v : sampled) all.push_back(points_[v]);
    const double spacing = 0.5 * options_.max_error, reach = 2 * options_.max_error + 2 * edge;
    const auto chosen = thinned(all, {}, spacing > edge ? spacing : 0);
    std::vector<Vec3> places, normals;
    for (const std::uint32_t s : chosen) {
      Vec3 sum = Vec3::Zero();
      for (const std::uint32_t t : fans_[sampled[s]]) sum += triangle_normal(mesh_, t);
      places.push_back(all[s]);
      normals.push_back(sum.normalized());
    }
    const KdTree tree(places);
    across_.resize(owners_.size());
    parallel_for(chosen.size(), context_.threads, [&](std::size_t begin, std::size_t end) {
      std::vector<Neighbour> near;
      for (std::size_t i = begin; i < end; ++i) {
        tree.within(places[i], reach, near);
        for (const Neighbour& n : near)
          if (normals[i].dot(normals[n.index]) < 0.5) across_[chosen[i]].push_back(chosen[n.index]);
      }
    });
  }

  std::size_t edge_triangles(std::uint32_t a, std::uint32_t b) const {
    std::size_t count = 0;
    for (const std::uint32_t t : fans_[a])
      count += triangles_[t][0] == b || triangles_[t][1] == b || triangles_[t][2] == b;
    return count;
  }

  void neighbours(std::uint32_t v, std::vector<std::uint32_t>& list) const {
    list.clear();
    for (const std::uint32_t t : fans_[v])
      for (const std::uint32_t w : triangles_[t])
        if (w != v) list.push_back(w);
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }

  /// The best place for the union of two vertices and what it costs.
  double best_place(std::uint32_t a, std::uint32_t b, Vec3& place) const {
    Quadric q = quadrics_[a];
    q += quadrics_[b];
    const Vec3 pa = points_[a] - origin_, pb = points_[b] - origin_, middle = 0.5 * (pa + pb);
    // Where planes leave a direction free, the middle of the edge is as good as any.
    const double weight = 1e-5 * q.a.trace() + 1e-300;
    const Mat3 system = q.a + weight * Mat3::Identity();
    place = solve_ldlt(system, Vec3(-q.b + weight * middle));
    const double sq_length = (pa - pb).squaredNorm();
    if (!place.allFinite() || (place - middle).squaredNorm() > 4 * sq_length) place = q.at(pa) <= q.at(pb) ? pa : pb;
    // Among equally flat edges short ones go first: they leave better triangles.
    const double cost = q.at(place) + 1e-7 * sq_length * sq_length;
    place += origin_;
    return cost;
  }

  void push(std::uint32_t a, std::uint32_t b) {
    if (!options_.frozen.empty() && (options_.frozen[a] || options_.frozen[b])) return;
    if (a > b) std::swap(a, b);
    Vec3 place;
    queue_.push({best_place(a, b, place), a, b, stamps_[a], stamps_[b]});
  }

  void fill_queue() {
    queue_ = {};
    std::vector<std::uint32_t> around;
    for (std::uint32_t v = 0; v < fans_.size(); ++v) {
      if (fans_[v].empty()) continue;
      neighbours(v, around);
      for (const std::uint32_t w : around)
        if (v < w) push(v, w);
    }
  }

  bool topology_allows(std::uint32_t a, std::uint32_t b) {
    const std::size_t shared = edge_triangles(a, b);
    if (shared == 0 || shared > 2) return false;
    if (shared == 2 && border_[a] && border_[b]) return false;
    neighbours(a, around_a_);
    neighbours(b, around_b_);
    common_.clear();
    std::set_intersection(around_a_.begin(), around_a_.end(), around_b_.begin(), around_b_.end(),
                          std::back_inserter(common_));
    if (common_.size() != shared) return false;
    for (const std::uint32_t v : common_)
      if (fans_[v].size() <= (border_[v] ? 1u : 3u)) return false;
    // Two triangles on the same three vertices would be left.
    return fans_[a].size() + fans_[b].size() - 2 * shared > 2 || border_[a] || border_[b];
  }

  bool try_place(std::uint32_t a, std::uint32_t b, const Vec3& place) {
    // Between samples a surface may be a little farther than at them.
    const double bound = 0.95 * options_.max_error;
    survivors_.clear();
    ring_.clear();
    for (const std::uint32_t v : {a, b})
      for (const std::uint32_t t : fans_[v]) {
        const Triangle& tri = triangles_[t];
        const bool has_both =
            (tri[0] == a || tri[1] == a || tri[2] == a) && (tri[0] == b || tri[1] == b || tri[2] == b);
        if (has_both && v == b) continue;
        ring_.push_back(t);
        if (has_both) continue;
        Corners now = {corner(t, 0), corner(t, 1), corner(t, 2)}, next = now;
        for (int k = 0; k < 3; ++k)
          if (tri[k] == a || tri[k] == b) next[k] = place;
        const Vec3 old_normal = (now[1] - now[0]).cross(now[2] - now[0]);
        const Vec3 new_normal = (next[1] - next[0]).cross(next[2] - next[0]);
        const double old_size = old_normal.norm(), new_size = new_normal.norm();
        const double old_shape = old_size / longest(now), new_shape = new_size / longest(next);
        if (!(new_size > 0)) return false;
        if (old_shape > 1e-3 && new_normal.dot(old_normal) < 0.2 * old_size * new_size) return false;
        if (new_shape < 5e-3 && new_shape < old_shape) return false;
        survivors_.push_back({t, next, new_normal / new_size});
      }
    if (survivors_.empty()) return false;
    if (!original_.closest_within(place, bound)) return false;
    // The original's samples must find a triangle...
    moved_.clear();
    for (const std::uint32_t t : ring_)
      for (const std::uint32_t s : samples_of_[t]) {
        double best = std::numeric_limits<double>::infinity();
        std::size_t at = 0;
        for (std::size_t k = 0; k < survivors_.size() && best > 0; ++k) {
          const Corners& c = survivors_[k].corners;
          // The plane's distance is a lower bound, and much cheaper.
          const double off = survivors_[k].normal.dot(samples_[s] - c[0]);
          if (off * off >= best) continue;
          const double d = (closest_on_triangle(samples_[s], c[0], c[1], c[2]) - samples_[s]).squaredNorm();
          if (d < best) best = d, at = k;
        }
        if (best > bound * bound) return false;
        moved_.push_back({s, static_cast<std::uint32_t>(at)});
      }
    // ...and the new triangles the original.
    for (const Survivor& survivor : survivors_) {
      const Corners& c = survivor.corners;
      const auto middle = original_.closest_within((c[0] + c[1] + c[2]) / 3, bound);
      if (!middle) return false;
      // On a thin wall the nearest surface may be the wrong side.
      if (triangle_normal(mesh_, middle->triangle).dot(survivor.normal) < -0.3) return false;
      const int n = std::clamp(static_cast<int>(std::ceil(std::sqrt(longest(c)) / probe_)), 2, 24);
      for (int i = 0; i <= n; ++i)
        for (int j = 0; i + j <= n; ++j) {
          if (i == n || j == n || i + j == 0) continue;
          const Vec3 p = (c[0] * (n - i - j) + c[1] * i + c[2] * j) / n;
          if (!original_.closest_within(p, bound)) return false;
        }
    }
    return !crosses(a, b);
  }

  /// Would the triangles of `survivors_` pass through each other, or through others nearby? Asked where surfaces are
  /// near each other only; what it misses elsewhere are folds that no normal has shown.
  bool crosses(std::uint32_t a, std::uint32_t b) {
    nearby_.clear();
    bool near_a_sample = false;
    ++look_;
    for (const std::uint32_t t : ring_) seen_[t] = look_;
    const auto add = [&](std::uint32_t t) {
      if (seen_[t] != look_) seen_[t] = look_, nearby_.push_back(t);
    };
    for (const std::uint32_t t : ring_)
      for (const std::uint32_t s : samples_of_[t])
        if (s < across_.size())
          for (const std::uint32_t other : across_[s]) near_a_sample = true, add(owners_[other]);
    if (!near_a_sample) return false;
    for (const std::uint32_t t : ring_)
      for (const std::uint32_t v : triangles_[t])
        if (v != a && v != b)
          for (const std::uint32_t other : fans_[v]) add(other);
    const auto next_of = [&](const Survivor& survivor) {
      PlacedTriangle next{triangles_[survivor.triangle], survivor.corners};
      std::replace(next.vertices.begin(), next.vertices.end(), b, a);
      return next;
    };
    for (std::size_t i = 0; i < survivors_.size(); ++i) {
      const PlacedTriangle next = next_of(survivors_[i]);
      for (std::size_t k = 0; k < i; ++k)
        if (triangles_cross(next, next_of(survivors_[k]))) return true;
      for (const std::uint32_t t : nearby_)
        if (triangles_cross(next, {triangles_[t], {corner(t, 0), corner(t, 1), corner(t, 2)}})) return true;
    }
    return false;
  }

  void try_collapse(std::uint32_t a, std::uint32_t b) {
    if (!topology_allows(a, b)) return;
    Vec3 place;
    best_place(a, b, place);
    if (!try_place(a, b, place)) {
      const Quadric &qa = quadrics_[a], &qb = quadrics_[b];
      const double cost_a = qb.at(points_[a] - origin_), cost_b = qa.at(points_[b] - origin_);
      if (border_[a] != border_[b])
        place = border_[a] ? points_[a] : points_[b];
      else
        place = cost_a <= cost_b ? points_[a] : points_[b];
      if (!try_place(a, b, place)) return;
    }
    // `survivors_`, `ring_` and `moved_` describe the accepted place.
    for (const std::uint32_t t : ring_) samples_of_[t].clear();
    for (const auto& [sample, at] : moved_) {
      samples_of_[survivors_[at].triangle].push_back(sample);
      if (sample < owners_.size()) owners_[sample] = survivors_[at].triangle;
    }
    std::vector<std::uint32_t> fan;
    for (const Survivor& survivor : survivors_) fan.push_back(survivor.triangle);
    std::sort(fan.begin(), fan.end());
    for (const std::uint32_t t : ring_) {
      if (std::binary_search(fan.begin(), fan.end(), t)) continue;
      alive_[t] = 0;
      --left_;
      for (const std::uint32_t v : triangles_[t])
        if (v != a && v != b) std::erase(fans_[v], t);
    }
    for (const std::uint32_t t : fan)
      for (std::uint32_t& v : triangles_[t])
        if (v == b) v = a;
    points_[a] = place;
    quadrics_[a] += quadrics_[b];
    border_[a] = border_[a] || border_[b];
    fans_[a] = std::move(fan);
    fans_[b].clear();
    ++stamps_[a], ++stamps_[b];
    neighbours(a, around_a_);
    for (const std::uint32_t v : around_a_) push(a, v);
  }

  TriangleMesh result() const {
    TriangleMesh out;
    std::vector<std::uint32_t> index(points_.size(), ~0u);
    for (std::uint32_t v = 0; v < points_.size(); ++v)
      if (!fans_[v].empty())
        index[v] = static_cast<std::uint32_t>(out.vertices.size()), out.vertices.push_back(points_[v]);
    for (std::uint32_t t = 0; t < triangles_.size(); ++t)
      if (alive_[t])
        out.triangles.push_back({index[triangles_[t][0]], index[triangles_[t][1]], index[triangles_[t][2]]});
    return out;
  }

  using Corners = std::array<Vec3, 3>;
  struct Survivor {
    std::uint32_t triangle;
    Corners corners;
    Vec3 normal;
  };
  struct Moved {
    std::uint32_t sample, at;
  };
  static double longest(const Corners& c) {
    return std::max({(c[1] - c[0]).squaredNorm(), (c[2] - c[1]).squaredNorm(), (c[0] - c[2]).squaredNorm()});
  }

  const TriangleMesh& mesh_;
  const DecimateOptions& options_;
  Context& context_;
  MeshDistance original_;
  Vec3 origin_;
  double probe_ = 1;  // mm between the places at which new triangles are checked
  std::size_t left_ = 0;
  std::vector<Vec3> points_, samples_;
  std::vector<Triangle> triangles_;
  std::vector<std::uint8_t> alive_, border_;
  std::vector<std::vector<std::uint32_t>> fans_, samples_of_, across_;
  std::vector<std::uint32_t> owners_;  // the triangle that each of the first samples, those at vertices, belongs to
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> stamps_;
  std::vector<std::uint32_t> seen_;  // of each triangle: when it was last put into nearby_ or the ring
  std::uint32_t look_ = 0;
  std::priority_queue<Candidate> queue_;
  std::vector<std::uint32_t> around_a_, around_b_, common_, ring_, nearby_;
  std::vector<Survivor> survivors_;
  std::vector<Moved> moved_;
};

}  // namespace

Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  // Voronoi regions of corners, edges and face [Ericson 2004].
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 != d3) return a + ab * (d1 / (d1 - d3));
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 != d6) return a + ac * (d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  const double e1 = d4 - d3, e2 = d5 - d6;
  if (va <= 0 && e1 >= 0 && e2 >= 0 && e1 + e2 > 0) return b + (c - b) * (e1 / (e1 + e2));
  const double sum = va + vb + vc;
  if (!(sum > 0)) return a;
  return a + ab * (vb / sum) + ac * (vc / sum);
}

TriangleMesh decimated(const TriangleMesh& mesh, const DecimateOptions& options, Context& context) {
  ensure(options.max_error >= 0, "an error bound is not negative");
  ensure(options.frozen.empty() || options.frozen.size() == mesh.vertices.size(), "one flag per vertex, or none");
  if (mesh.empty()) return mesh;
  return Decimator(mesh, options, context).run();
}

}  // namespace partscribe::geometry
