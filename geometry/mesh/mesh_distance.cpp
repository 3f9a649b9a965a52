#include "geometry/mesh/mesh_distance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>

#include "core/ensure.h"
#include "core/parallel.h"
#include "geometry/mesh/pseudonormals.h"
#include "geometry/mesh/triangle_tree.h"
#include "geometry/points/spatial_order.h"

namespace partscribe::geometry {
namespace {

constexpr std::size_t chunk_size = std::size_t(1) << 20;  // queries sorted together
constexpr std::size_t block_size = 2048;                  // queries of one thread in a row
constexpr std::size_t batch_size = 1024;                  // queries searched together

/// Where on a triangle the nearest point lies: 0 inside, 1..3 edge k-1, 4..6 corner k-4.
struct Foot {
  double sq_distance = std::numeric_limits<double>::infinity();
  Vec3 point = Vec3::Zero();
  int feature = 0;
};

inline void nearest_on_edge(const Vec3& p, const Vec3& a, const Vec3& b, int k, Foot& best) {
  const Vec3 ab = b - a;
  const double along = ab.dot(p - a), length2 = ab.squaredNorm();
  Foot foot;
  if (along <= 0) {
    foot.point = a, foot.feature = 4 + k;
  } else if (along >= length2) {
    foot.point = b, foot.feature = 4 + (k + 1) % 3;
  } else {
    foot.point = a + along / length2 * ab, foot.feature = 1 + k;
  }
  foot.sq_distance = (p - foot.point).squaredNorm();
  if (foot.sq_distance < best.sq_distance) best = foot;
}

Foot foot_on(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 ab = b - a, bc = c - b, ca = a - c, pa = p - a, n = bc.cross(ca);
  const double nn = n.squaredNorm();
  if (ab.dot(pa.cross(n)) > 0 && bc.dot((p - b).cross(n)) > 0 && ca.dot((p - c).cross(n)) > 0) {
    const double height = n.dot(pa);
    return {height * height / nn, p - height / nn * n, 0};
  }
  Foot foot;
  nearest_on_edge(p, a, b, 0, foot);
  nearest_on_edge(p, b, c, 1, foot);
  nearest_on_edge(p, c, a, 2, foot);
  return foot;
}

}  // namespace

struct MeshDistance::Parts {
  const TriangleMesh& mesh;
  TriangleTree tree;
  // Made when the first sign is asked for.
  std::once_flag signs_made;
  Pseudonormals signs;

  Parts(const TriangleMesh& m, int threads) : mesh(m), tree(build_triangle_tree(m, threads)) {}

  void prepare_signs() {
    std::call_once(signs_made, [&] { signs = pseudonormals(mesh); });
  }

  MeshHit hit_at(const Vec3& query, const NearestSlot& best, Sign sign) const {
    ensure(best.triangle != no_triangle, "no nearest triangle: the query or the mesh is not finite");
    MeshHit hit;
    hit.triangle = best.triangle;
    hit.distance = std::sqrt(best.sq_distance);
    if (sign == Sign::none) {
      // The leaf is at hand; the mesh may be far away in memory.
      hit.point = foot_on(tree.corner(best, 0), tree.corner(best, 1), tree.corner(best, 2), query).point;
    } else {
      const auto& corner = mesh.triangles[hit.triangle];
      const Foot foot = foot_on(mesh.vertices[corner[0]], mesh.vertices[corner[1]], mesh.vertices[corner[2]], query);
      hit.point = foot.point;
      const Vec3 normal = foot.feature == 0   ? triangle_normal(mesh, hit.triangle)
                          : foot.feature <= 3 ? signs.of_edge(hit.triangle, foot.feature - 1)
                                              : signs.of_corner(mesh, hit.triangle, foot.feature - 4);
      if ((query - foot.point).dot(normal) < 0) hit.distance = -hit.distance;
    }
    return hit;
  }
};

MeshDistance::MeshDistance(const TriangleMesh& mesh, int threads) : parts_(std::make_unique<Parts>(mesh, threads)) {}
MeshDistance::~MeshDistance() = default;
MeshDistance::MeshDistance(MeshDistance&&) noexcept = default;

std::size_t MeshDistance::tree_bytes() const { return parts_->tree.bytes(); }

MeshHit MeshDistance::closest(const Vec3& query) const {
  ensure(!parts_->tree.nodes.empty(), "the nearest place on a mesh without triangles was asked for");
  NearestSlot best;
  search_nearest(parts_->tree, query, best);
  return parts_->hit_at(query, best, Sign::none);
}

std::optional<MeshHit> MeshDistance::closest_within(const Vec3& query, double bound) const {
  if (!(bound >= 0)) return std::nullopt;
  NearestSlot best;
  best.sq_distance = std::min(bound * bound, std::numeric_limits<double>::max());
  search_nearest(parts_->tree, query, best);
  if (best.triangle == no_triangle) return std::nullopt;
  return parts_->hit_at(query, best, Sign::none);
}

bool MeshDistance::comes_within(const Vec3& query, double bound, MeshHint& hint) const {
  if (!(bound >= 0)) return false;
  NearestSlot best;
  best.sq_distance = std::min(bound * bound, std::numeric_limits<double>::max());
  NearestSlot before;
  before.triangle = hint.triangle, before.leaf = hint.leaf;
  if (start_from(parts_->tree, query, before).sq_distance <= best.sq_distance) return true;
  search_nearest(parts_->tree, query, best);
  if (best.triangle == no_triangle) return false;
  hint = {best.triangle, best.leaf};
  return true;
}

double MeshDistance::signed_distance(const Vec3& query) const {
  MeshHit hit;
  return signed_distance(query, hit);
}

double MeshDistance::signed_distance(const Vec3& query, MeshHit& hit) const {
  ensure(!parts_->tree.nodes.empty(), "the signed distance to a mesh without triangles was asked for");
  parts_->prepare_signs();
  NearestSlot best;
  search_nearest(parts_->tree, query, best);
  hit = parts_->hit_at(query, best, Sign::inside_negative);
  const double distance = hit.distance;
  hit.distance = std::abs(distance);
  return distance;
}

std::vector<MeshHit> MeshDistance::closest(std::span<const Vec3> queries, int threads, Sign sign) const {
  std::vector<MeshHit> hits(queries.size());
  for_each_closest(queries, threads, sign, [&](std::size_t index, const MeshHit& hit) { hits[index] = hit; });
  return hits;
}

void MeshDistance::for_each_closest(std::span<const Vec3> queries, int threads, Sign sign,
                                    const std::function<void(std::size_t, const MeshHit&)>& take) const {
  if (queries.empty()) return;
  ensure(!parts_->tree.nodes.empty(), "nearest places on a mesh without triangles were asked for");
  if (sign == Sign::inside_negative) parts_->prepare_signs();
  for (std::size_t start = 0; start < queries.size(); start += chunk_size) {
    const auto chunk = queries.subspan(start, std::min(chunk_size, queries.size() - start));
    const std::vector<std::uint32_t> order = spatial_order(chunk, threads);
    parallel_for(
        order.size(), threads,
        [&](std::size_t begin, std::size_t end) {
          std::array<Vec3, batch_size> batch, points;
          std::array<NearestSlot, batch_size> found;
          for (std::size_t i = begin; i < end; i += batch_size) {
            const std::size_t count = std::min(batch_size, end - i);
            // Fetched together, the queries wait for memory once and not one after the other.
            for (std::size_t k = 0; k < count; ++k) batch[k] = chunk[order[i + k]];
            search_nearest(parts_->tree, {batch.data(), count}, found.data());
            if (sign == Sign::inside_negative) {
              // The mesh itself may be far away in memory.
              const TriangleMesh& mesh = parts_->mesh;
              auto known = [&](std::size_t k) { return found[k].triangle != no_triangle; };
              for (std::size_t k = 0; k < count; ++k)
                if (known(k)) __builtin_prefetch(&mesh.triangles[found[k].triangle]);
              for (std::size_t k = 0; k < count; ++k)
                if (known(k))
                  for (const auto vertex : mesh.triangles[found[k].triangle])
                    __builtin_prefetch(&mesh.vertices[vertex]);
              for (std::size_t k = 0; k < count; ++k)
                take(start + order[i + k], parts_->hit_at(batch[k], found[k], sign));
              continue;
            }
            for (std::size_t k = 0; k < count; ++k)
              ensure(found[k].triangle != no_triangle, "no nearest triangle: the query or the mesh is not finite");
            nearest_points(parts_->tree, {batch.data(), count}, found.data(), points.data());
            for (std::size_t k = 0; k < count; ++k)
              take(start + order[i + k], {std::sqrt(found[k].sq_distance), found[k].triangle, points[k]});
          }
        },
        block_size);
  }
}

std::optional<MeshHit> MeshDistance::first_hit(const Vec3& ray_origin, const Vec3& direction, double max_t) const {
  const TriangleTree& tree = parts_->tree;
  if (tree.nodes.empty() || !(max_t > 0)) return std::nullopt;
  const Vec3 o = ray_origin - tree.origin;
  const Vec3 inverse(1 / direction.x(), 1 / direction.y(), 1 / direction.z());
  double best_t = max_t;
  std::uint32_t best_triangle = no_triangle;
  // Entry parameter of the ray into a child's box, or infinity. Boxes are a little too large, so no slab is ever too
  // thin.
  auto entry = [&](const TriangleTree::Node& node, std::uint32_t lane) {
    double enter = 0, leave = best_t;
    for (int k = 0; k < 3; ++k) {
      const double low = node.low[k][lane], high = node.high[k][lane];
      if (direction[k] == 0) {
        if (o[k] < low || o[k] > high) return std::numeric_limits<double>::infinity();
        continue;
      }
      double t0 = (low - o[k]) * inverse[k], t1 = (high - o[k]) * inverse[k];
      if (t0 > t1) std::swap(t0, t1);
      enter = std::max(enter, t0 - 1e-14 * std::abs(t0)), leave = std::min(leave, t1 + 1e-14 * std::abs(t1));
    }
    return enter <= leave ? enter : std::numeric_limits<double>::infinity();
  };
  auto try_leaf = [&](const TriangleTree::Leaf& leaf) {
    for (std::size_t i = 0; i < leaf.count; ++i) {
      auto corner = [&](std::size_t c) { return TriangleTree::corner(leaf, i, c); };
      const Vec3 a = corner(0), ab = corner(1) - a, ac = corner(2) - a, across = direction.cross(ac);
      const double determinant = ab.dot(across);
      if (determinant == 0) continue;
      // A hair of overlap beyond the edges: a ray through a shared edge meets one triangle or both, never none.
      constexpr double hair = 1e-10;
      const Vec3 from_a = ray_origin - a;
      const double u = from_a.dot(across) / determinant;
      if (!(u >= -hair && u <= 1 + hair)) continue;
      const Vec3 q = from_a.cross(ab);
      const double v = direction.dot(q) / determinant;
      if (!(v >= -hair && u + v <= 1 + hair)) continue;
      const double t = ac.dot(q) / determinant;
      const std::uint32_t triangle = leaf.triangle[i];
      if (t > 0 && (t < best_t || (t == best_t && triangle < best_triangle))) best_t = t, best_triangle = triangle;
    }
  };
  struct Pending {
    double t;
    std::uint32_t child;
  };
  Pending pending[TriangleTree::most_pending];
  int top = 0;
  pending[top++] = {0, 0};
  while (top > 0) {
    const Pending here = pending[--top];
    if (here.t > best_t) continue;
    if (TriangleTree::is_leaf(here.child)) {
      try_leaf(tree.leaf(here.child));
      continue;
    }
    const TriangleTree::Node& node = tree.nodes[here.child];
    const int base = top;
    for (std::uint32_t lane = 0; lane < node.children; ++lane) {
      const double t = entry(node, lane);
      if (!(t <= best_t) || !(t < INFINITY)) continue;
      int i = top++;  // the nearest on top
      for (; i > base && pending[i - 1].t < t; --i) pending[i] = pending[i - 1];
      pending[i] = {t, node.child[lane]};
    }
  }
  if (best_triangle == no_triangle) return std::nullopt;
  return MeshHit{best_t, best_triangle, ray_origin + best_t * direction};
}

}  // namespace partscribe::geometry
