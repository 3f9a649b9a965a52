#include "geometry/mesh/bounded_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "geometry/decompose.h"
#include "geometry/mesh/self_intersection.h"
#include "geometry/points/kd_tree.h"
#include "geometry/points/thin.h"

namespace partscribe::geometry {
namespace {

double sq_longest(const MeshEdit::Corners& c) {
  return std::max({(c[1] - c[0]).squaredNorm(), (c[2] - c[1]).squaredNorm(), (c[0] - c[2]).squaredNorm()});
}

constexpr double share_of_bound = 0.99;  // what is left makes up for what is not exact

struct Nearest {
  double sq_distance = std::numeric_limits<double>::infinity();
  std::uint32_t at = 0;  // of the added triangles
  bool above = false;    // does it project into the inside?
};

/// The first triangle from `start` on, and round, within `sq_bound` that p lies above; where there is none, the
/// nearest.
Nearest nearest(const MeshEdit& edit, const Vec3& p, double sq_bound, std::uint32_t start) {
  for (std::uint32_t i = 0, k = start; i < edit.added.size(); ++i, k = k + 1 < edit.added.size() ? k + 1 : 0) {
    const MeshEdit::Added& t = edit.added[k];
    const Vec3 a = p - t.corners[0];
    if (t.inward[0].dot(a) < 0 || t.inward[2].dot(a) < 0 || t.inward[1].dot(p - t.corners[1]) < 0) continue;
    const double off = t.normal.dot(a);
    if (off * off <= sq_bound) return {off * off, k, true};
  }
  Nearest best;
  for (std::uint32_t k = 0; k < edit.added.size(); ++k) {
    const MeshEdit::Corners& c = edit.added[k].corners;
    // The plane's distance is a lower bound, and much cheaper.
    const double off = edit.added[k].normal.dot(p - c[0]);
    if (off * off >= best.sq_distance) continue;
    const double d = (closest_on_triangle(p, c[0], c[1], c[2]) - p).squaredNorm();
    if (d < best.sq_distance) best = {d, k, false};
  }
  return best;
}

}  // namespace

BoundedMesh::BoundedMesh(const TriangleMesh& mesh, double bound, Context& context)
    : mesh_(mesh),
      original_(mesh),
      walk_(mesh),
      bound_(bound),
      origin_(mesh.bounds().center()),
      points_(mesh.vertices),
      triangles_(mesh.triangles) {
  const std::size_t n = mesh.vertices.size(), m = mesh.triangles.size();
  seen_.assign(m, 0);
  unrest_.assign(m, 0);
  fans_.resize(n);
  feet_.resize(n);
  border_.assign(n, 0);
  samples_of_.resize(m);
  left_ = m;
  if (m == 0) return;
  double edge_sum = 0;
  for (std::uint32_t t = 0; t < m; ++t) {
    const auto c = corners(t);
    edge_sum += (c[1] - c[0]).norm() + (c[2] - c[1]).norm() + (c[0] - c[2]).norm();
    for (const std::uint32_t v : triangles_[t]) fans_[v].push_back(t);
  }
  edge_ = edge_sum / (3.0 * static_cast<double>(m));
  std::vector<std::uint32_t> sampled, sample_at(n, ~0u);
  for (std::uint32_t v = 0; v < n; ++v)
    if (!fans_[v].empty()) {
      sample_at[v] = static_cast<std::uint32_t>(sampled.size());
      sampled.push_back(v), owners_.push_back(fans_[v].front()), add_sample(fans_[v].front(), points_[v]);
      feet_[v] = walk_.inside(fans_[v].front(), points_[v]);
    }
  planes_.resize(sampled.size());
  for (std::uint32_t t = 0; t < m; ++t) {
    const auto c = corners(t);
    const Vec3 twice = (c[1] - c[0]).cross(c[2] - c[0]);
    const double size = twice.norm();
    if (!(size > 0)) continue;
    for (int k = 0; k < 3; ++k) planes_[sample_at[triangles_[t][k]]].add_plane(twice / size, c[0] - origin_, size / 6);
    bool bent = false;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
      const Vec3 along = c[(k + 1) % 3] - c[k];
      const std::uint32_t beyond = walk_.across(t, k);
      if (beyond == no_neighbour) {
        border_[a] = border_[b] = 1;
        const int n = std::clamp(static_cast<int>(along.norm() / std::max(0.25 * bound_, edge_ / 8)), 1, 64);
        for (int i = 1; i < n; ++i) add_sample(t, c[k] + along * i / n);
        // A wall on the border edge keeps it in place.
        const Vec3 wall = along.cross(twice).normalized();
        for (const std::uint32_t v : {a, b})
          planes_[sample_at[v]].add_plane(wall, c[k] - origin_, 2 * along.squaredNorm());
        continue;
      }
      const double turn = std::acos(std::clamp(walk_.normal(beyond).dot(twice) / size, -1.0, 1.0));
      // How far the middle of the edge may lie from a surface that meets the original at its corners.
      if (!(turn * along.norm() / 8 > 0.02 * bound_)) continue;
      bent = true;
      if (beyond > t) add_sample(t, 0.5 * (c[k] + c[(k + 1) % 3]));
    }
    if (bent) add_sample(t, (c[0] + c[1] + c[2]) / 3);
  }
  for (const std::uint32_t v : sampled) on_border_.push_back(border_[v]);
  sample_borders();
  find_narrow_places(sampled, context);
}

/// Beside borders surfaces do not face each other: large triangles there are sampled all over.
void BoundedMesh::sample_borders() {
  beside_border_.assign(triangles_.size(), 0);
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    for (const std::uint32_t v : triangles_[t]) beside_border_[t] |= border_[v];
    if (!beside_border_[t]) continue;
    const auto c = corners(t);
    const int n = std::clamp(static_cast<int>(std::sqrt(sq_longest(c)) / std::max(bound_, edge_ / 8)) + 1, 1, 32);
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j)
        if (i < n && j < n && i + j > 0) add_sample(t, (c[0] * (n - i - j) + c[1] * i + c[2] * j) / n);
  }
}

std::vector<Quadric> BoundedMesh::quadrics() const {
  std::vector<Quadric> result(points_.size());
  for (std::uint32_t t = 0; t < triangles_.size(); ++t)
    for (const std::uint32_t s : samples_of_[t]) {
      if (s >= planes_.size()) continue;
      const Vec3 share = barycentric(corners(t), samples_[s]);
      for (int k = 0; k < 3; ++k)
        if (share[k] > 0) result[triangles_[t][k]].add(planes_[s], share[k]);
    }
  return result;
}

MeshEdit::Corners BoundedMesh::corners(std::uint32_t t) const {
  const Triangle& v = triangles_[t];
  return {points_[v[0]], points_[v[1]], points_[v[2]]};
}

void BoundedMesh::add_sample(std::uint32_t t, const Vec3& p) {
  samples_of_[t].push_back(static_cast<std::uint32_t>(samples_.size()));
  samples_.push_back(p);
}

/// Notes for the first samples, those at the vertices `sampled`, which others of another sheet or of the other side
/// of an edge lie so near that changed surfaces could meet there.
void BoundedMesh::find_narrow_places(const std::vector<std::uint32_t>& sampled, Context& context) {
  std::vector<Vec3> all;
  for (const std::uint32_t v : sampled) all.push_back(points_[v]);
  const double spacing = 0.5 * bound_, reach = 2 * bound_ + 2 * edge_;
  const auto chosen = thinned(all, {}, spacing > edge_ ? spacing : 0);
  std::vector<Vec3> places, normals;
  for (const std::uint32_t s : chosen) {
    Vec3 sum = Vec3::Zero();
    for (const std::uint32_t t : fans_[sampled[s]]) sum += walk_.normal(t);
    places.push_back(all[s]);
    normals.push_back(sum.normalized());
  }
  const KdTree tree(places);
  across_.resize(owners_.size());
  parallel_for(chosen.size(), context.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    for (std::size_t i = begin; i < end; ++i) {
      tree.within(places[i], reach, near);
      for (const Neighbour& n : near)
        if (normals[i].dot(normals[n.index]) < 0.5) across_[chosen[i]].push_back(chosen[n.index]);
    }
  });
}

std::size_t BoundedMesh::edge_triangles(std::uint32_t a, std::uint32_t b) const {
  std::size_t count = 0;
  for (const std::uint32_t t : fans_[a])
    count += triangles_[t][0] == b || triangles_[t][1] == b || triangles_[t][2] == b;
  return count;
}

void BoundedMesh::neighbours(std::uint32_t v, std::vector<std::uint32_t>& list) const {
  list.clear();
  for (const std::uint32_t t : fans_[v])
    for (const std::uint32_t w : triangles_[t])
      if (w != v) list.push_back(w);
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

bool BoundedMesh::add(MeshEdit& edit, std::uint32_t t, const Triangle& vertices) const {
  const auto c = corners(t);
  const Vec3 before = (c[1] - c[0]).cross(c[2] - c[0]);
  return add(edit, t, vertices, before, before.norm() / sq_longest(c));
}

bool BoundedMesh::add_across(MeshEdit& edit, std::uint32_t t, const Triangle& vertices, const Vec3& before) const {
  return add(edit, t, vertices, before, 1);
}

bool BoundedMesh::add(MeshEdit& edit, std::uint32_t t, const Triangle& vertices, const Vec3& before,
                      double shape_before) const {
  MeshEdit::Corners next;
  for (int k = 0; k < 3; ++k) next[k] = vertices[k] == edit.moved ? edit.place : points_[vertices[k]];
  const Vec3 normal = (next[1] - next[0]).cross(next[2] - next[0]);
  const double size = normal.norm(), shape = size / sq_longest(next);
  if (!(size > 0)) return false;
  if (shape_before > 1e-3 && normal.dot(before) < 0.2 * before.norm() * size) return false;
  if (shape < 5e-3 && shape < shape_before) return false;
  MeshEdit::Added added{t, vertices, next, normal / size, {}};
  for (int k = 0; k < 3; ++k) added.inward[k] = added.normal.cross(next[(k + 1) % 3] - next[k]);
  edit.added.push_back(added);
  return true;
}

double BoundedMesh::unrest(const std::vector<std::uint32_t>& triangles) const {
  double sum = 0;
  for (const std::uint32_t t : triangles) sum += unrest_[t];
  return sum;
}

bool BoundedMesh::allows(const MeshEdit& edit, double most_unrest) {
  if (edit.added.empty()) return false;
  const double bound = share_of_bound * bound_, sq_bound = bound * bound;
  if (edit.moved != ~0u) {
    const auto foot = original_.closest_within(edit.place, bound);
    if (!foot) return false;
    foot_ = walk_.inside(foot->triangle, foot->point);
  }
  // The original's samples must find a triangle...
  moved_.clear();
  unrest_of_added_.assign(edit.added.size(), 0);
  double sum = 0;
  std::uint32_t last = 0;
  for (const std::uint32_t t : edit.removed)
    for (std::size_t i = 0; i < samples_of_[t].size(); ++i) {
      const std::uint32_t s = samples_of_[t][i];
      const Nearest near = nearest(edit, samples_[s], sq_bound, last);
      if (near.sq_distance > sq_bound) {
        // What forbids one edit will forbid the next: it is asked first.
        std::swap(samples_of_[t][0], samples_of_[t][i]);
        return false;
      }
      last = near.at;
      const double share = near.sq_distance / sq_bound;
      unrest_of_added_[near.at] += share * share;
      if ((sum += share * share) >= most_unrest) return false;
      moved_.push_back({s, near.at});
    }
  return !strays(edit, bound) && !crosses(edit);
}

/// Does a new triangle face the wrong way, or come farther from the original than the bound with an edge or inside?
bool BoundedMesh::strays(const MeshEdit& edit, double bound) {
  // Where the surfaces face each other, they are farthest apart at corners of the original (its samples), at corners
  // of the mesh, and where edges of both cross.
  for (const MeshEdit::Added& added : edit.added) {
    // Needles do not show by themselves that they turned over.
    const auto faces = [&](std::uint32_t v) {
      return walk_.normal((v == edit.moved ? foot_ : feet_[v]).triangle).dot(added.normal) > -0.3;
    };
    if (std::none_of(added.vertices.begin(), added.vertices.end(), faces)) return true;
  }
  for (std::size_t i = 0; i < edit.added.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = edit.added[i].vertices[k], w = edit.added[i].vertices[(k + 1) % 3];
      if (edit.moved != ~0u ? v != edit.moved && w != edit.moved : edge_triangles(v, w) > 0) continue;
      const auto same = [&](const MeshEdit::Added& other) {
        for (int l = 0; l < 3; ++l)
          if (other.vertices[l] == w && other.vertices[(l + 1) % 3] == v) return true;
        return false;
      };
      if (std::any_of(edit.added.begin(), edit.added.begin() + i, same)) continue;
      const Vec3 &a = edit.added[i].corners[k], &b = edit.added[i].corners[(k + 1) % 3];
      const Walk walk =
          walk_.along(a, v == edit.moved ? foot_ : feet_[v], b, w == edit.moved ? foot_ : feet_[w], bound);
      if (walk == Walk::beyond) return true;
      if (walk == Walk::within) continue;
      // Along a border it is probed: as far as the bound leaves room from a place nothing can stray.
      const double length = (b - a).norm();
      for (double along = 0; along < length;) {
        const auto hit = original_.closest_within(a + (b - a) * (along / length), bound);
        if (!hit) return true;
        along += std::max(bound - hit->distance, edge_ / 64);
      }
    }
  // A triangle at a border, or one that has samples of it, may lie over a hole.
  over_border_.clear();
  for (const MeshEdit::Added& added : edit.added)
    over_border_.push_back(
        std::any_of(added.vertices.begin(), added.vertices.end(), [&](std::uint32_t v) { return border_[v] != 0; }));
  for (const auto& [sample, at] : moved_)
    if (sample < on_border_.size() && on_border_[sample]) over_border_[at] = 1;
  for (std::size_t i = 0; i < edit.added.size(); ++i)
    // Between probes it may be a little farther than at them.
    if (over_border_[i] && !covered(edit.added[i].corners, 0.95 * bound, edge_, true)) return true;
  return false;
}

/// Are probes inside a triangle, `pitch` apart, within the bound of the original? Finer ones follow beside borders.
bool BoundedMesh::covered(const MeshEdit::Corners& c, double bound, double pitch, bool refine) const {
  const int n = std::clamp(static_cast<int>(std::ceil(std::sqrt(sq_longest(c)) / pitch)), 2, 64);
  MeshHint hint;
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      const Vec3 p = (c[0] * (n - i - j) + c[1] * i + c[2] * j) / n, u = (c[1] - c[0]) / n, v = (c[2] - c[0]) / n;
      if (!original_.comes_within(p, bound, hint)) return false;
      if (!refine || hint.triangle == ~0u || !beside_border_[hint.triangle]) continue;
      if (!covered({p, p + u, p + v}, bound, pitch / 8, false)) return false;
      if (i + j + 2 <= n && !covered({p + u, p + u + v, p + v}, bound, pitch / 8, false)) return false;
    }
  return true;
}

/// Would the new triangles pass through each other, or through others nearby? Asked where surfaces are near each other
/// only; what it misses elsewhere are folds that no normal has shown.
bool BoundedMesh::crosses(const MeshEdit& edit) {
  nearby_.clear();
  bool near_a_sample = false;
  ++look_;
  for (const std::uint32_t t : edit.removed) seen_[t] = look_;
  const auto note = [&](std::uint32_t t) {
    if (seen_[t] != look_) seen_[t] = look_, nearby_.push_back(t);
  };
  for (const std::uint32_t t : edit.removed)
    for (const std::uint32_t s : samples_of_[t])
      if (s < across_.size())
        for (const std::uint32_t other : across_[s]) near_a_sample = true, note(owners_[other]);
  if (!near_a_sample) return false;
  // On a thin wall the nearest surface may be the wrong side.
  for (const MeshEdit::Added& added : edit.added) {
    const auto& c = added.corners;
    const MeshHit middle = original_.closest((c[0] + c[1] + c[2]) / 3);
    if (walk_.normal(middle.triangle).dot(added.normal) < -0.3) return true;
  }
  for (const std::uint32_t t : edit.removed)
    for (const std::uint32_t v : triangles_[t])
      for (const std::uint32_t other : fans_[v]) note(other);
  for (std::size_t i = 0; i < edit.added.size(); ++i) {
    const PlacedTriangle next{edit.added[i].vertices, edit.added[i].corners};
    for (std::size_t k = 0; k < i; ++k)
      if (triangles_cross(next, {edit.added[k].vertices, edit.added[k].corners})) return true;
    for (const std::uint32_t t : nearby_)
      if (triangles_cross(next, {triangles_[t], corners(t)})) return true;
  }
  return false;
}

void BoundedMesh::make(const MeshEdit& edit) {
  for (const std::uint32_t t : edit.removed) {
    samples_of_[t].clear();
    unrest_[t] = 0;
    for (const std::uint32_t v : triangles_[t]) std::erase(fans_[v], t);
  }
  left_ += edit.added.size();
  left_ -= edit.removed.size();
  for (std::size_t k = 0; k < edit.added.size(); ++k) {
    const std::uint32_t t = edit.added[k].triangle;
    const Triangle& vertices = edit.added[k].vertices;
    triangles_[t] = vertices;
    unrest_[t] = unrest_of_added_[k];
    for (const std::uint32_t v : vertices) fans_[v].insert(std::lower_bound(fans_[v].begin(), fans_[v].end(), t), t);
  }
  for (const auto& [sample, at] : moved_) {
    samples_of_[edit.added[at].triangle].push_back(sample);
    if (sample < owners_.size()) owners_[sample] = edit.added[at].triangle;
  }
  if (edit.moved != ~0u) points_[edit.moved] = edit.place, feet_[edit.moved] = foot_;
}

Vec3 BoundedMesh::better_place(const MeshEdit& edit) const {
  // A foot follows the vertex as its barycentric coordinate says.
  Mat3 system = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  std::uint32_t last = 0;
  for (const std::uint32_t t : edit.removed)
    for (const std::uint32_t s : samples_of_[t]) {
      const Vec3& p = samples_[s];
      const Nearest near = nearest(edit, p, bound_ * bound_, last);
      last = near.at;
      if (!(near.sq_distance > 0.01 * bound_ * bound_)) continue;  // what counts little
      const MeshEdit::Added& added = edit.added[near.at];
      const auto& c = added.corners;
      const auto k = std::find(added.vertices.begin(), added.vertices.end(), edit.moved) - added.vertices.begin();
      if (k == 3) continue;
      const Vec3 off = near.above ? Vec3(added.normal.dot(p - c[0]) * added.normal)
                                  : Vec3(p - closest_on_triangle(p, c[0], c[1], c[2]));
      const auto next = (k + 1) % 3;
      const double share = added.inward[next].dot(p - off - c[next]) / added.inward[next].dot(c[k] - c[next]);
      system += share * share * off * off.transpose();
      right += near.sq_distance * share * off;
    }
  const double damping = 1e-3 * system.trace();
  if (!(damping > 0)) return edit.place;
  return edit.place + solve_ldlt(Mat3(system + damping * Mat3::Identity()), right);
}

TriangleMesh BoundedMesh::result() const {
  TriangleMesh out;
  std::vector<std::uint32_t> index(points_.size(), ~0u);
  std::vector<std::uint8_t> alive(triangles_.size(), 0);
  for (std::uint32_t v = 0; v < points_.size(); ++v) {
    if (fans_[v].empty()) continue;
    index[v] = static_cast<std::uint32_t>(out.vertices.size()), out.vertices.push_back(points_[v]);
    for (const std::uint32_t t : fans_[v]) alive[t] = 1;
  }
  for (std::uint32_t t = 0; t < triangles_.size(); ++t)
    if (alive[t]) out.triangles.push_back({index[triangles_[t][0]], index[triangles_[t][1]], index[triangles_[t][2]]});
  return out;
}

Vec3 barycentric(const MeshEdit::Corners& c, const Vec3& p) {
  const Vec3 twice = (c[1] - c[0]).cross(c[2] - c[0]), foot = closest_on_triangle(p, c[0], c[1], c[2]);
  const double sq_size = twice.squaredNorm();
  Vec3 result = Vec3::Zero();
  if (sq_size > 0)
    for (int k = 0; k < 3; ++k)
      result[k] = (c[(k + 2) % 3] - c[(k + 1) % 3]).cross(foot - c[(k + 1) % 3]).dot(twice) / sq_size;
  return result;
}

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

}  // namespace partscribe::geometry
