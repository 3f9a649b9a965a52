#include "geometry/mesh_distance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>
#include <vector>

#include "core/ensure.h"

namespace partscribe {
namespace {

constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();
constexpr int leaf_size = 4;
constexpr int bins = 16;
constexpr int sah_depth = 56;      // below it splits are by count, so that the stack of a query is bounded
constexpr int stack_size = 128;

/// Both children's boxes, relative to the mesh's centre and rounded outward: one cache line.
struct alignas(64) Node {
  float low[2][3], high[2][3];
  std::uint32_t child[2];  // a node, or the first triangle of a leaf
  std::uint32_t count[2];  // triangles of a leaf; 0: a node
};

/// A triangle in leaf order with what every query needs of it.
struct Facet {
  Vec3 a, b, c;
  Vec3 normal;              // unit, zero without area
  std::uint32_t triangle;   // index in the mesh
  std::uint8_t swapped;     // bit k: edge k runs from its larger to its smaller corner
};

bool lexicographically_less(const Vec3& a, const Vec3& b) {
  if (a.x() != b.x()) return a.x() < b.x();
  if (a.y() != b.y()) return a.y() < b.y();
  return a.z() < b.z();
}

/// Where on a triangle the nearest point lies: 0 inside, 1..3 edge k-1, 4..6 corner k-4.
struct Foot {
  double sq_distance;
  Vec3 point;
  int feature;
};

/// Nearest point of the segment; always computed from its smaller corner, so that two triangles that share the
/// edge get the same bits and the tie is a tie.
inline void nearest_on_edge(const Vec3& p, const Vec3& from, const Vec3& to, bool swapped, int k, Foot& best) {
  const Vec3& a = swapped ? to : from;
  const Vec3& b = swapped ? from : to;
  const Vec3 ab = b - a;
  const double along = ab.dot(p - a), length2 = ab.squaredNorm();
  Vec3 point;
  int feature;
  if (along <= 0) {
    point = a, feature = 4 + (swapped ? (k + 1) % 3 : k);
  } else if (along >= length2) {
    point = b, feature = 4 + (swapped ? k : (k + 1) % 3);
  } else {
    point = a + along / length2 * ab, feature = 1 + k;
  }
  const double sq = (p - point).squaredNorm();
  if (sq < best.sq_distance) best = {sq, point, feature};
}

/// The closest point lies inside, or on an edge that the query is outside of (convexity), so only those are tried.
inline Foot nearest_on(const Facet& f, const Vec3& p) {
  const Vec3 pa = p - f.a, pb = p - f.b, pc = p - f.c;
  const Vec3 ab = f.b - f.a, bc = f.c - f.b, ca = f.a - f.c;
  const double side_ab = f.normal.dot(ab.cross(pa)), side_bc = f.normal.dot(bc.cross(pb)),
               side_ca = f.normal.dot(ca.cross(pc));
  Foot foot{std::numeric_limits<double>::infinity(), f.a, 4};
  const bool flat = f.normal.x() == 0 && f.normal.y() == 0 && f.normal.z() == 0;
  if (!flat && side_ab > 0 && side_bc > 0 && side_ca > 0) {
    const double height = f.normal.dot(pa);
    return {height * height, p - height * f.normal, 0};
  }
  if (flat || side_ab <= 0) nearest_on_edge(p, f.a, f.b, f.swapped & 1, 0, foot);
  if (flat || side_bc <= 0) nearest_on_edge(p, f.b, f.c, f.swapped & 2, 1, foot);
  if (flat || side_ca <= 0) nearest_on_edge(p, f.c, f.a, f.swapped & 4, 2, foot);
  return foot;
}

inline double sq_distance_to_box(const float* low, const float* high, const double* p) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double d = std::max(std::max(low[k] - p[k], p[k] - high[k]), 0.0);
    sum += d * d;
  }
  return sum;
}

float rounded_down(double v) { return std::nextafter(static_cast<float>(v), -std::numeric_limits<float>::infinity()); }
float rounded_up(double v) { return std::nextafter(static_cast<float>(v), std::numeric_limits<float>::infinity()); }

double half_area(const Box3& box) {
  if (box.empty()) return 0;
  const Vec3 s = box.size();
  return s.x() * s.y() + s.y() * s.z() + s.z() * s.x();
}

}  // namespace

struct MeshDistance::Tree {
  const TriangleMesh& mesh;
  Vec3 origin = Vec3::Zero();
  double margin = 0;
  std::vector<Node> nodes;
  std::vector<Facet> facets;
  // Pseudonormals are made when the first sign is asked for.
  std::once_flag signs_made;
  std::vector<std::array<Vec3, 3>> edge_normals, corner_normals;

  explicit Tree(const TriangleMesh& m) : mesh(m) {
    if (mesh.triangles.empty()) return;
    build();
  }

  // ---- building ---------------------------------------------------------------------------------------------------

  struct Item {
    Box3 box;
    Vec3 center;
    std::uint32_t triangle;
  };

  void build() {
    Box3 all;
    std::vector<Item> items(mesh.triangles.size());
    for (std::uint32_t t = 0; t < items.size(); ++t) {
      items[t].triangle = t;
      for (int k = 0; k < 3; ++k) items[t].box.add(mesh.corner(t, k));
      items[t].center = items[t].box.center();
      all.add(items[t].box.low), all.add(items[t].box.high);
    }
    origin = all.center();
    // Slack for the rounding of differences: a box must never seem farther than a triangle in it.
    margin = 1e-12 * (all.low.cwiseAbs().maxCoeff() + all.high.cwiseAbs().maxCoeff());
    facets.reserve(items.size());
    nodes.reserve(items.size() / 2 + 2);
    nodes.emplace_back();
    Node root{};
    if (items.size() <= leaf_size) {
      set_child(root, 0, all, make_leaf(items, 0, items.size()), static_cast<std::uint32_t>(items.size()));
      for (int k = 0; k < 3; ++k) root.low[1][k] = INFINITY, root.high[1][k] = -INFINITY;
      root.child[1] = 0, root.count[1] = 0;
    } else {
      split(items, 0, items.size(), 0, root);
    }
    nodes[0] = root;
  }

  void set_child(Node& node, int side, const Box3& box, std::uint32_t child, std::uint32_t count) const {
    for (int k = 0; k < 3; ++k) {
      node.low[side][k] = rounded_down(box.low[k] - origin[k] - margin);
      node.high[side][k] = rounded_up(box.high[k] - origin[k] + margin);
    }
    node.child[side] = child, node.count[side] = count;
  }

  std::uint32_t make_leaf(std::vector<Item>& items, std::size_t begin, std::size_t end) {
    const auto first = static_cast<std::uint32_t>(facets.size());
    for (std::size_t i = begin; i < end; ++i) {
      const auto t = items[i].triangle;
      Facet f;
      f.a = mesh.corner(t, 0), f.b = mesh.corner(t, 1), f.c = mesh.corner(t, 2);
      f.normal = triangle_normal(mesh, t);
      f.triangle = t;
      f.swapped = static_cast<std::uint8_t>((lexicographically_less(f.b, f.a) ? 1 : 0) |
                                            (lexicographically_less(f.c, f.b) ? 2 : 0) |
                                            (lexicographically_less(f.a, f.c) ? 4 : 0));
      facets.push_back(f);
    }
    return first;
  }

  /// Cuts [begin, end) in two by the surface area heuristic on binned centres and fills both sides of `node`.
  void split(std::vector<Item>& items, std::size_t begin, std::size_t end, int depth, Node& node) {
    Box3 centers;
    for (std::size_t i = begin; i < end; ++i) centers.add(items[i].center);
    const Vec3 extent = centers.size();
    std::size_t middle = begin;
    if (depth < sah_depth && end - begin > 2) {
      double best_cost = std::numeric_limits<double>::infinity();
      int best_axis = -1, best_bin = 0;
      for (int axis = 0; axis < 3; ++axis) {
        if (!(extent[axis] > 0)) continue;
        std::array<Box3, bins> boxes;
        std::array<std::size_t, bins> counts{};
        const double scale = bins / extent[axis];
        for (std::size_t i = begin; i < end; ++i) {
          const int b = bin_of(items[i].center[axis], centers.low[axis], scale);
          ++counts[b];
          boxes[b].add(items[i].box.low), boxes[b].add(items[i].box.high);
        }
        std::array<double, bins> right_cost{};
        Box3 box;
        std::size_t count = 0;
        for (int b = bins - 1; b > 0; --b) {
          if (counts[b]) box.add(boxes[b].low), box.add(boxes[b].high);
          count += counts[b];
          right_cost[b] = half_area(box) * static_cast<double>(count);
        }
        box = {}, count = 0;
        for (int b = 0; b + 1 < bins; ++b) {
          if (counts[b]) box.add(boxes[b].low), box.add(boxes[b].high);
          count += counts[b];
          if (count == 0 || count == end - begin) continue;
          const double cost = half_area(box) * static_cast<double>(count) + right_cost[b + 1];
          if (cost < best_cost) best_cost = cost, best_axis = axis, best_bin = b;
        }
      }
      if (best_axis >= 0) {
        const double scale = bins / extent[best_axis];
        const auto it = std::stable_partition(items.begin() + long(begin), items.begin() + long(end), [&](const Item& item) {
          return bin_of(item.center[best_axis], centers.low[best_axis], scale) <= best_bin;
        });
        middle = static_cast<std::size_t>(it - items.begin());
      }
    }
    if (middle == begin || middle == end) middle = begin + (end - begin) / 2;
    const std::size_t cut[3] = {begin, middle, end};
    for (int side = 0; side < 2; ++side) {
      Box3 box;
      for (std::size_t i = cut[side]; i < cut[side + 1]; ++i) box.add(items[i].box.low), box.add(items[i].box.high);
      const std::size_t count = cut[side + 1] - cut[side];
      if (count <= leaf_size) {
        set_child(node, side, box, make_leaf(items, cut[side], cut[side + 1]), static_cast<std::uint32_t>(count));
      } else {
        const auto index = static_cast<std::uint32_t>(nodes.size());
        nodes.emplace_back();
        Node child{};
        split(items, cut[side], cut[side + 1], depth + 1, child);
        nodes[index] = child;
        set_child(node, side, box, index, 0);
      }
    }
  }

  static int bin_of(double v, double low, double scale) {
    return std::clamp(static_cast<int>((v - low) * scale), 0, bins - 1);
  }

  // ---- nearest point ----------------------------------------------------------------------------------------------

  struct Found {
    double sq_distance;
    Vec3 point = Vec3::Zero();
    std::uint32_t triangle = nobody;
    int feature = 0;
  };

  Found nearest(const Vec3& query, double sq_bound) const {
    Found best{sq_bound, Vec3::Zero(), nobody, 0};
    if (nodes.empty()) return best;
    const Vec3 relative = query - origin;
    const double p[3] = {relative.x(), relative.y(), relative.z()};
    struct Entry {
      double sq_distance;
      std::uint32_t node;
    };
    Entry stack[stack_size];
    int top = 0;
    stack[top++] = {0, 0};
    while (top > 0) {
      const Entry entry = stack[--top];
      if (entry.sq_distance > best.sq_distance) continue;
      std::uint32_t index = entry.node;
      for (;;) {
        const Node& node = nodes[index];
        double sq[2];
        for (int side = 0; side < 2; ++side)
          sq[side] = sq_distance_to_box(node.low[side], node.high[side], p);
        const int near_side = sq[1] < sq[0] ? 1 : 0;
        std::uint32_t next = nobody;
        for (const int side : {near_side, 1 - near_side}) {
          if (!(sq[side] <= best.sq_distance) || !(sq[side] < INFINITY)) continue;
          if (node.count[side] > 0) {
            for (std::uint32_t i = node.child[side], e = i + node.count[side]; i < e; ++i) {
              const Foot foot = nearest_on(facets[i], query);
              if (foot.sq_distance < best.sq_distance ||
                  (foot.sq_distance == best.sq_distance && facets[i].triangle < best.triangle))
                best = {foot.sq_distance, foot.point, facets[i].triangle, foot.feature};
            }
          } else if (next == nobody && side == near_side) {
            next = node.child[side];
          } else {
            stack[top++] = {sq[side], node.child[side]};
          }
        }
        if (next == nobody) break;
        index = next;
      }
    }
    return best;
  }

  // ---- sign -------------------------------------------------------------------------------------------------------

  /// Angle-weighted normals of every corner and summed normals of every edge, over vertices united by position.
  void make_signs() {
    const std::size_t count = mesh.triangles.size();
    std::vector<std::uint32_t> order(mesh.vertices.size()), united(mesh.vertices.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      const Vec3 &p = mesh.vertices[a], &q = mesh.vertices[b];
      return lexicographically_less(p, q) ? true : lexicographically_less(q, p) ? false : a < b;
    });
    for (std::size_t i = 0; i < order.size(); ++i)
      united[order[i]] = i > 0 && mesh.vertices[order[i]] == mesh.vertices[order[i - 1]] ? united[order[i - 1]] : order[i];

    std::vector<Vec3> face(count), vertex(mesh.vertices.size(), Vec3::Zero());
    for (std::size_t t = 0; t < count; ++t) {
      face[t] = triangle_normal(mesh, t);
      for (int k = 0; k < 3; ++k) {
        const Vec3 a = mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k);
        const Vec3 b = mesh.corner(t, (k + 2) % 3) - mesh.corner(t, k);
        vertex[united[mesh.triangles[t][k]]] += std::atan2(a.cross(b).norm(), a.dot(b)) * face[t];
      }
    }
    struct Use {
      std::uint64_t key;
      std::uint32_t triangle;
      std::uint8_t edge;
    };
    std::vector<Use> uses;
    uses.reserve(count * 3);
    for (std::uint32_t t = 0; t < count; ++t)
      for (std::uint8_t k = 0; k < 3; ++k) {
        const std::uint64_t a = united[mesh.triangles[t][k]], b = united[mesh.triangles[t][(k + 1) % 3]];
        uses.push_back({std::min(a, b) << 32 | std::max(a, b), t, k});
      }
    std::sort(uses.begin(), uses.end(), [](const Use& a, const Use& b) {
      return a.key != b.key ? a.key < b.key : a.triangle != b.triangle ? a.triangle < b.triangle : a.edge < b.edge;
    });
    edge_normals.assign(count, {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()});
    corner_normals.resize(count);
    auto sum_edges = [&] {
      for (std::size_t i = 0; i < uses.size();) {
        std::size_t end = i;
        Vec3 sum = Vec3::Zero();
        for (; end < uses.size() && uses[end].key == uses[i].key; ++end) sum += face[uses[end].triangle];
        for (; i < end; ++i) edge_normals[uses[i].triangle][uses[i].edge] = sum;
      }
    };
    sum_edges();
    // A triangle without area stands for the faces behind it: lend it their mean normal, so that an edge that
    // meets the solid only through such a sliver still knows both of its sides.
    bool lent = false;
    for (std::size_t t = 0; t < count; ++t) {
      if (face[t] != Vec3::Zero()) continue;
      int longest = 0;
      for (int k = 1; k < 3; ++k)
        if (edge_length(t, k) > edge_length(t, longest)) longest = k;
      const Vec3 behind = edge_normals[t][(longest + 1) % 3] + edge_normals[t][(longest + 2) % 3];
      if (behind.norm() > 0) face[t] = behind.normalized(), lent = true;
    }
    if (lent) sum_edges();
    for (std::size_t t = 0; t < count; ++t)
      for (int k = 0; k < 3; ++k) corner_normals[t][k] = vertex[united[mesh.triangles[t][k]]];
  }

  double edge_length(std::size_t t, int k) const { return (mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k)).norm(); }
};

MeshDistance::MeshDistance(const TriangleMesh& mesh) : tree_(std::make_unique<Tree>(mesh)) {}
MeshDistance::~MeshDistance() = default;
MeshDistance::MeshDistance(MeshDistance&&) noexcept = default;

MeshHit MeshDistance::closest(const Vec3& query) const {
  ensure(!tree_->nodes.empty(), "the nearest place on a mesh without triangles was asked for");
  const auto found = tree_->nearest(query, std::numeric_limits<double>::max());
  ensure(found.triangle != nobody, "no nearest triangle: the query or the mesh is not finite");
  return {std::sqrt(found.sq_distance), found.triangle, found.point};
}

std::optional<MeshHit> MeshDistance::closest_within(const Vec3& query, double bound) const {
  if (!(bound >= 0)) return std::nullopt;
  const auto found = tree_->nearest(query, std::min(bound * bound, std::numeric_limits<double>::max()));
  if (found.triangle == nobody) return std::nullopt;
  return MeshHit{std::sqrt(found.sq_distance), found.triangle, found.point};
}

double MeshDistance::signed_distance(const Vec3& query) const {
  MeshHit hit;
  return signed_distance(query, hit);
}

double MeshDistance::signed_distance(const Vec3& query, MeshHit& hit) const {
  ensure(!tree_->nodes.empty(), "the signed distance to a mesh without triangles was asked for");
  std::call_once(tree_->signs_made, [&] { tree_->make_signs(); });
  const auto found = tree_->nearest(query, std::numeric_limits<double>::max());
  ensure(found.triangle != nobody, "no nearest triangle: the query or the mesh is not finite");
  const Vec3 normal = found.feature == 0   ? triangle_normal(tree_->mesh, found.triangle)
                      : found.feature <= 3 ? tree_->edge_normals[found.triangle][found.feature - 1]
                                           : tree_->corner_normals[found.triangle][found.feature - 4];
  const double distance = std::sqrt(found.sq_distance);
  hit = {distance, found.triangle, found.point};
  return (query - found.point).dot(normal) < 0 ? -distance : distance;
}

std::optional<MeshHit> MeshDistance::first_hit(const Vec3& ray_origin, const Vec3& direction, double max_t) const {
  const Tree& tree = *tree_;
  if (tree.nodes.empty() || !(max_t > 0)) return std::nullopt;
  const Vec3 o = ray_origin - tree.origin;
  double best_t = max_t;
  std::uint32_t best_triangle = nobody;
  // Entry parameter of the ray into a box, or infinity. Boxes are a little too large, so no slab is ever too thin.
  auto entry = [&](const float* low, const float* high) {
    double enter = 0, leave = best_t;
    for (int k = 0; k < 3; ++k) {
      if (direction[k] == 0) {
        if (o[k] < low[k] || o[k] > high[k]) return std::numeric_limits<double>::infinity();
        continue;
      }
      double t0 = (low[k] - o[k]) / direction[k], t1 = (high[k] - o[k]) / direction[k];
      if (t0 > t1) std::swap(t0, t1);
      enter = std::max(enter, t0 - 1e-14 * std::abs(t0)), leave = std::min(leave, t1 + 1e-14 * std::abs(t1));
    }
    return enter <= leave ? enter : std::numeric_limits<double>::infinity();
  };
  struct Entry {
    double t;
    std::uint32_t node;
  };
  Entry stack[stack_size];
  int top = 0;
  stack[top++] = {0, 0};
  while (top > 0) {
    const Entry here = stack[--top];
    if (here.t > best_t) continue;
    const Node& node = tree.nodes[here.node];
    double t[2];
    for (int side = 0; side < 2; ++side) t[side] = entry(node.low[side], node.high[side]);
    const int near_side = t[1] < t[0] ? 1 : 0;
    for (const int side : {1 - near_side, near_side}) {  // the nearer one last: it is popped first
      if (!(t[side] <= best_t) || !(t[side] < INFINITY)) continue;
      if (node.count[side] == 0) {
        stack[top++] = {t[side], node.child[side]};
        continue;
      }
      for (std::uint32_t i = node.child[side], e = i + node.count[side]; i < e; ++i) {
        const Facet& f = tree.facets[i];
        const Vec3 ab = f.b - f.a, ac = f.c - f.a, across = direction.cross(ac);
        const double determinant = ab.dot(across);
        if (determinant == 0) continue;
        // A hair of overlap beyond the edges: a ray through a shared edge meets one triangle or both, never none.
        constexpr double hair = 1e-10;
        const Vec3 from_a = ray_origin - f.a;
        const double u = from_a.dot(across) / determinant;
        if (!(u >= -hair && u <= 1 + hair)) continue;
        const Vec3 q = from_a.cross(ab);
        const double v = direction.dot(q) / determinant;
        if (!(v >= -hair && u + v <= 1 + hair)) continue;
        const double at = ac.dot(q) / determinant;
        if (at > 0 && (at < best_t || (at == best_t && f.triangle < best_triangle)))
          best_t = at, best_triangle = f.triangle;
      }
    }
  }
  if (best_triangle == nobody) return std::nullopt;
  return MeshHit{best_t, best_triangle, ray_origin + best_t * direction};
}

}  // namespace partscribe
