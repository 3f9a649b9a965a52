#include "geometry/mesh/self_intersection.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace partscribe::geometry {
namespace {

double side(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return (b - a).cross(c - a).dot(d - a); }

/// Does the open segment p-q pass through the inside of triangle a, b, c?
bool pierces(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const double sp = side(a, b, c, p), sq = side(a, b, c, q);
  if ((sp >= 0 && sq >= 0) || (sp <= 0 && sq <= 0)) return false;
  const double u = side(p, q, a, b), v = side(p, q, b, c), w = side(p, q, c, a);
  return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

/// Boxes in a tree over a permuted list; leaves hold a few.
class BoxTree {
 public:
  explicit BoxTree(const std::vector<Box3>& boxes) : boxes_(boxes), order_(boxes.size()) {
    for (std::uint32_t i = 0; i < order_.size(); ++i) order_[i] = i;
    if (!order_.empty()) build(0, order_.size());
  }
  /// Calls `visit` for every box that meets `box`.
  template <class Visit>
  void meeting(const Box3& box, Visit&& visit) const {
    std::vector<std::uint32_t> stack;
    if (!nodes_.empty()) stack.push_back(0);
    while (!stack.empty()) {
      const Node& node = nodes_[stack.back()];
      stack.pop_back();
      if (!meet(node.box, box)) continue;
      if (node.right == 0) {
        for (std::size_t i = node.begin; i < node.end; ++i)
          if (meet(boxes_[order_[i]], box)) visit(order_[i]);
      } else {
        stack.push_back(node.left);
        stack.push_back(node.right);
      }
    }
  }

 private:
  struct Node {
    Box3 box;
    std::size_t begin = 0, end = 0;
    std::uint32_t left = 0, right = 0;
  };
  static bool meet(const Box3& a, const Box3& b) {
    return (a.low.array() <= b.high.array()).all() && (b.low.array() <= a.high.array()).all();
  }
  std::uint32_t build(std::size_t begin, std::size_t end) {
    const auto at = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    Box3 box, centers;
    for (std::size_t i = begin; i < end; ++i) {
      box.add(boxes_[order_[i]].low), box.add(boxes_[order_[i]].high);
      centers.add(boxes_[order_[i]].center());
    }
    nodes_[at].box = box;
    nodes_[at].begin = begin, nodes_[at].end = end;
    if (end - begin <= 4) return at;
    Eigen::Index axis = 0;
    centers.size().maxCoeff(&axis);
    const std::size_t middle = (begin + end) / 2;
    std::nth_element(order_.begin() + static_cast<std::ptrdiff_t>(begin),
                     order_.begin() + static_cast<std::ptrdiff_t>(middle),
                     order_.begin() + static_cast<std::ptrdiff_t>(end), [&](std::uint32_t a, std::uint32_t b) {
                       const double ca = boxes_[a].center()[axis], cb = boxes_[b].center()[axis];
                       return ca != cb ? ca < cb : a < b;
                     });
    const std::uint32_t left = build(begin, middle), right = build(middle, end);
    nodes_[at].left = left, nodes_[at].right = right;
    return at;
  }
  const std::vector<Box3>& boxes_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

PlacedTriangle placed(const TriangleMesh& mesh, std::uint32_t t) {
  return {mesh.triangles[t], {mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)}};
}

}  // namespace

bool triangles_cross(const PlacedTriangle& a, const PlacedTriangle& b) {
  for (Eigen::Index k = 0; k < 3; ++k) {
    const auto [a_low, a_high] = std::minmax({a.corners[0][k], a.corners[1][k], a.corners[2][k]});
    const auto [b_low, b_high] = std::minmax({b.corners[0][k], b.corners[1][k], b.corners[2][k]});
    if (a_low > b_high || b_low > a_high) return false;
  }
  int shared = 0;
  for (const std::uint32_t v : a.vertices)
    for (const std::uint32_t w : b.vertices) shared += v == w;
  if (shared >= 2) return false;
  for (const auto& pair : {std::pair{&a, &b}, std::pair{&b, &a}})
    for (std::size_t k = 0; k < 3; ++k) {
      const auto *s = pair.first, *t = pair.second;
      const std::size_t next = (k + 1) % 3;
      const auto is_corner = [&](std::uint32_t v) { return std::count(t->vertices.begin(), t->vertices.end(), v) > 0; };
      // An edge that ends in a corner of the other triangle cannot pass through its inside.
      if (is_corner(s->vertices[k]) || is_corner(s->vertices[next])) continue;
      if (pierces(s->corners[k], s->corners[next], t->corners[0], t->corners[1], t->corners[2])) return true;
    }
  return false;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> self_intersections(const TriangleMesh& mesh, std::size_t limit) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> result;
  std::vector<Box3> boxes(mesh.triangles.size());
  for (std::size_t t = 0; t < boxes.size(); ++t)
    for (int k = 0; k < 3; ++k) boxes[t].add(mesh.corner(t, k));
  const BoxTree tree(boxes);
  for (std::uint32_t a = 0; a < boxes.size() && result.size() < limit; ++a) {
    const PlacedTriangle own = placed(mesh, a);
    tree.meeting(boxes[a], [&](std::uint32_t b) {
      if (b > a && triangles_cross(own, placed(mesh, b))) result.push_back({a, b});
    });
  }
  std::sort(result.begin(), result.end());
  if (result.size() > limit) result.resize(limit);
  return result;
}

}  // namespace partscribe::geometry
