#include "geometry/kd_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/ensure.h"
#include "core/parallel.h"

namespace partscribe {
namespace {

constexpr std::size_t leaf_size = 16;
constexpr double infinity = std::numeric_limits<double>::infinity();

bool nearer(const Neighbour& a, const Neighbour& b) {
  return a.sq_distance != b.sq_distance ? a.sq_distance < b.sq_distance : a.index < b.index;
}

/// The points of one leaf by coordinate; what is not filled lies at infinity.
struct Leaf {
  std::array<double, leaf_size> x, y, z;
  std::array<std::uint32_t, leaf_size> index;

  void sq_distances(const Vec3& p, double* result) const {
    const double px = p.x(), py = p.y(), pz = p.z();
    for (std::size_t k = 0; k < leaf_size; ++k) {
      const double dx = px - x[k], dy = py - y[k], dz = pz - z[k];
      result[k] = dx * dx + dy * dy + dz * dz;
    }
  }
};

/// Boxes are looked at in pairs of coordinates: comparisons that the compiler turns into jumps cost half of a search.
typedef double Two __attribute__((vector_size(16)));
inline Two larger(Two a, Two b) { return a > b ? a : b; }

/// Of a run of leaves, with the tight box of their points; two halves follow unless it is a single leaf.
struct Node {
  Two low_xy, high_xy, low_z, high_z;  // the last of z is zero
  std::uint32_t first, last;           // leaves [first, last)
  std::uint32_t left, right;

  bool is_leaf() const { return last - first == 1; }
  /// No point inside is nearer, not even in the last bit: rounding keeps the order of every term and of their sum.
  double sq_distance(Two xy, Two z) const { return square(larger(low_xy - xy, xy - high_xy), larger(low_z - z, z - high_z)); }
  double sq_distance(const Vec3& p) const { return sq_distance(Two{p.x(), p.y()}, Two{p.z(), 0}); }
  double sq_distance(const Node& other) const {
    return square(larger(low_xy - other.high_xy, other.low_xy - high_xy), larger(low_z - other.high_z, other.low_z - high_z));
  }

 private:
  static double square(Two xy, Two z) {
    xy = larger(xy, Two{}), z = larger(z, Two{});
    xy *= xy, z *= z;
    return xy[0] + xy[1] + z[0];
  }
};

/// The nearest so far, nearest first, in memory of the caller.
class Nearest {
 public:
  Nearest(Neighbour* list, std::size_t capacity) : list_(list), capacity_(capacity) {}
  double worst() const { return worst_; }
  std::size_t size() const { return size_; }

  void add(double sq_distance, std::uint32_t index) {
    const Neighbour item{index, sq_distance};
    std::size_t at = size_;
    if (size_ == capacity_) {
      if (!nearer(item, list_[size_ - 1])) return;
      --at;
    } else {
      ++size_;
    }
    for (; at > 0 && nearer(item, list_[at - 1]); --at) list_[at] = list_[at - 1];
    list_[at] = item;
    if (size_ == capacity_) worst_ = list_[size_ - 1].sq_distance;
  }

  void add(const Leaf& leaf, const Vec3& query) {
    double sq_distance[leaf_size];
    leaf.sq_distances(query, sq_distance);
    for (std::size_t k = 0; k < leaf_size; ++k)
      if (sq_distance[k] <= worst_) add(sq_distance[k], leaf.index[k]);
  }

 private:
  Neighbour* list_;
  std::size_t capacity_, size_ = 0;
  double worst_ = std::numeric_limits<double>::max();  // so that what lies at infinity is never added
};

/// Points that may be among the nearest.
struct Candidates {
  std::vector<double> sq_distance;  // filled up with infinity
  std::vector<std::uint32_t> index, place;
  std::size_t size = 0;

  void reserve(std::size_t count) {
    if (index.size() >= count + leaf_size) return;
    sq_distance.resize(2 * count + leaf_size), index.resize(2 * count + leaf_size);
  }
  /// Those of a leaf that are not farther than `limit`; without branches, for nobody can foretell which.
  void add(const Leaf& leaf, const Vec3& query, double limit) {
    double distances[leaf_size];
    leaf.sq_distances(query, distances);
    std::size_t at = size;
    double* const to = sq_distance.data();
    std::uint32_t* const from = index.data();
    for (std::size_t k = 0; k < leaf_size; ++k) {
      to[at] = distances[k], from[at] = leaf.index[k];
      at += distances[k] <= limit;
    }
    size = at;
  }
};

/// How many candidates are nearer than each: without branches, four at a time.
__attribute__((always_inline)) inline void count_nearer(const Candidates& c, std::uint32_t* place) {
  typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));
  typedef long long Counts __attribute__((vector_size(32)));
  const double* const d = c.sq_distance.data();
  for (std::size_t i = 0; i < c.size; ++i) {
    const Four own = {d[i], d[i], d[i], d[i]};
    Counts count{};
    for (std::size_t j = 0; j < c.size; j += 4) count -= *reinterpret_cast<const Four*>(d + j) < own;
    place[i] = static_cast<std::uint32_t>(count[0] + count[1] + count[2] + count[3]);
  }
}
void count_nearer_plain(const Candidates& c, std::uint32_t* place) { count_nearer(c, place); }
#if defined(__x86_64__)
__attribute__((target("avx2"))) void count_nearer_avx2(const Candidates& c, std::uint32_t* place) { count_nearer(c, place); }
#endif
void count_nearer_best(const Candidates& c, std::uint32_t* place) {
#if defined(__x86_64__)
  static const bool wide = __builtin_cpu_supports("avx2");
  if (wide) return count_nearer_avx2(c, place);
#endif
  count_nearer_plain(c, place);
}

/// The nearest `count` of the candidates, nearest first.
void take_nearest(Candidates& c, std::size_t count, std::vector<Neighbour>& list) {
  constexpr std::size_t most_counted = 400;  // beyond, sorting is faster
  if (c.size > most_counted) {
    list.resize(c.size);
    for (std::size_t k = 0; k < c.size; ++k) list[k] = {c.index[k], c.sq_distance[k]};
    std::nth_element(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(count - 1), list.end(), nearer);
    std::sort(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(count), nearer);
    list.resize(count);
    return;
  }
  for (std::size_t k = c.size; k < c.size + 4; ++k) c.sq_distance[k] = infinity;
  c.place.resize(c.size);
  count_nearer_best(c, c.place.data());
  // Equally far ones share a place: they move on to free ones, and are put in order of their indices.
  constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();
  list.assign(c.size, {nobody, 0});
  bool ties = false;
  for (std::size_t k = 0; k < c.size; ++k) {
    std::size_t at = c.place[k];
    while (list[at].index != nobody) ++at, ties = true;
    list[at] = {c.index[k], c.sq_distance[k]};
  }
  if (ties) std::sort(list.begin(), list.end(), nearer);
  list.resize(count);
}

struct Scratch {
  Candidates candidates;
  std::vector<Neighbour> list;
  std::vector<std::uint32_t> others, chosen;  // nodes, leaves
};

}  // namespace

struct KdTree::Tree {
  std::size_t finite = 0;
  std::vector<Leaf> leaves;
  std::vector<Node> nodes;

  struct Item {
    Vec3 point;
    std::uint32_t index;
  };

  explicit Tree(const std::vector<Vec3>& points) {
    std::vector<Item> items;
    items.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      if (points[i].allFinite()) items.push_back({points[i], static_cast<std::uint32_t>(i)});
    finite = items.size();
    leaves.resize((finite + leaf_size - 1) / leaf_size);
    nodes.reserve(2 * leaves.size());
    if (finite > 0) build(items, 0, leaves.size());
  }

  std::uint32_t build(std::vector<Item>& items, std::size_t first, std::size_t last) {
    const auto begin = items.begin() + static_cast<std::ptrdiff_t>(first * leaf_size);
    const auto end = items.begin() + static_cast<std::ptrdiff_t>(std::min(last * leaf_size, items.size()));
    Box3 box;
    for (auto i = begin; i != end; ++i) box.add(i->point);
    const auto own = static_cast<std::uint32_t>(nodes.size());
    Node node;
    node.low_xy = Two{box.low.x(), box.low.y()}, node.high_xy = Two{box.high.x(), box.high.y()};
    node.low_z = Two{box.low.z(), 0}, node.high_z = Two{box.high.z(), 0};
    node.first = static_cast<std::uint32_t>(first), node.last = static_cast<std::uint32_t>(last), node.left = node.right = 0;
    nodes.push_back(node);
    if (last - first == 1) {
      Leaf& leaf = leaves[first];
      leaf.x.fill(infinity), leaf.y.fill(infinity), leaf.z.fill(infinity), leaf.index.fill(0);
      std::size_t k = 0;
      for (auto i = begin; i != end; ++i, ++k)
        leaf.x[k] = i->point.x(), leaf.y[k] = i->point.y(), leaf.z[k] = i->point.z(), leaf.index[k] = i->index;
      return own;
    }
    Eigen::Index axis = 0;
    box.size().maxCoeff(&axis);
    const std::size_t middle = (first + last) / 2;  // all leaves but the last are full
    std::nth_element(begin, items.begin() + static_cast<std::ptrdiff_t>(middle * leaf_size), end,
                     [axis](const Item& a, const Item& b) { return a.point[axis] < b.point[axis]; });
    const std::uint32_t left = build(items, first, middle), right = build(items, middle, last);
    nodes[own].left = left, nodes[own].right = right;
    return own;
  }

  /// The nearest of all points of one leaf. One is asked in full; what it found bounds what the others can find.
  void nearest_of_leaf(std::size_t number, std::size_t count, Scratch& scratch,
                       const std::function<void(std::uint32_t, std::span<const Neighbour>)>& use) const {
    auto& [c, list, others, chosen] = scratch;
    const Leaf& leaf = leaves[number];
    const std::size_t size = std::min(finite - number * leaf_size, leaf_size);
    std::array<double, leaf_size> reach;  // of the points so far: distance of the last of the nearest
    double widest = 0;                    // that `others` are complete to
    for (std::size_t k = 0; k < size; ++k) {
      const Vec3 query(leaf.x[k], leaf.y[k], leaf.z[k]);
      double apart[leaf_size];
      leaf.sq_distances(query, apart);
      double limit;
      if (k == 0) {
        list.resize(count);
        Nearest near(list.data(), count);
        visit(query, [&] { return near.worst(); }, [&](const Leaf& other) { near.add(other, query); });
        limit = near.worst();
      } else {
        std::size_t next = 0;
        for (std::size_t j = 1; j < k; ++j) next = apart[j] < apart[next] ? j : next;
        limit = reach[next] + std::sqrt(apart[next]);
        limit = std::min(limit * limit * (1 + 1e-12) + std::numeric_limits<double>::min(), std::numeric_limits<double>::max());
        if (limit > widest) widest = collect(number, limit, others);
        c.size = 0;
        // Chosen without branches first, for half of them would be foretold wrong.
        chosen.resize(others.size());
        std::size_t asked = 0;
        for (const std::uint32_t other : others) {
          const Node& node = nodes[other];
          chosen[asked] = node.first;
          asked += node.sq_distance(query) <= limit;
        }
        c.reserve(asked * leaf_size + 8);
        for (std::size_t j = 0; j < asked; ++j) c.add(leaves[chosen[j]], query, limit);
        take_nearest(c, count, list);
        limit = list.back().sq_distance;
      }
      reach[k] = std::sqrt(limit);
      use(leaf.index[k], list);
    }
  }

  /// All leaves within `sq_distance` of one; returns what they are complete to.
  double collect(std::size_t number, double sq_distance, std::vector<std::uint32_t>& result) const {
    sq_distance *= 1.5;  // for the next ones, too
    std::uint32_t own = 0;
    while (!nodes[own].is_leaf()) own = number < nodes[nodes[own].left].last ? nodes[own].left : nodes[own].right;
    result.clear();
    std::array<std::uint32_t, 64> open;
    std::size_t count_open = 1;
    open[0] = 0;
    while (count_open > 0) {
      const std::uint32_t at = open[--count_open];
      if (nodes[at].sq_distance(nodes[own]) > sq_distance) continue;
      if (nodes[at].is_leaf())
        result.push_back(at);
      else
        open[count_open++] = nodes[at].right, open[count_open++] = nodes[at].left;
    }
    return sq_distance;
  }

  /// Calls `use(leaf)` for leaves not farther than `limit()`, the nearer half first.
  template <class Limit, class Use>
  void visit(const Vec3& query, const Limit& limit, const Use& use) const {
    if (nodes.empty()) return;
    struct Open {
      std::uint32_t node;
      double sq_distance;
    };
    std::array<Open, 64> open;  // one for each level at most
    std::size_t count_open = 0;
    Open at{0, nodes[0].sq_distance(query)};
    while (true) {
      if (at.sq_distance <= limit()) {
        const Node& node = nodes[at.node];
        if (!node.is_leaf()) {
          Open left{node.left, nodes[node.left].sq_distance(query)}, right{node.right, nodes[node.right].sq_distance(query)};
          if (right.sq_distance < left.sq_distance) std::swap(left, right);
          open[count_open++] = right;
          at = left;
          continue;
        }
        use(leaves[node.first]);
      }
      if (count_open == 0) return;
      at = open[--count_open];
    }
  }
};

KdTree::KdTree(const std::vector<Vec3>& points) : tree_(std::make_unique<Tree>(points)) {}
KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;

void KdTree::nearest(const Vec3& query, std::size_t count, std::vector<Neighbour>& result) const {
  result.clear();
  count = std::min(count, tree_->finite);
  if (count == 0) return;
  result.resize(count);
  Nearest near(result.data(), count);
  tree_->visit(query, [&] { return near.worst(); }, [&](const Leaf& leaf) { near.add(leaf, query); });
  result.resize(near.size());
}

void KdTree::nearest_of_each(std::size_t count, int threads,
                             const std::function<void(std::uint32_t, std::span<const Neighbour>)>& use) const {
  const Tree& tree = *tree_;
  count = std::min(count, tree.finite);
  if (count == 0) return;
  parallel_for(
      tree.leaves.size(), threads,
      [&](std::size_t begin, std::size_t end) {
        Scratch scratch;
        for (std::size_t i = begin; i < end; ++i) tree.nearest_of_leaf(i, count, scratch, use);
      },
      64);
}

void KdTree::within(const Vec3& query, double radius, std::vector<Neighbour>& result) const {
  result.clear();
  const double sq_radius = std::min(radius * radius, std::numeric_limits<double>::max());
  tree_->visit(
      query, [&] { return sq_radius; },
      [&](const Leaf& leaf) {
        double sq_distance[leaf_size];
        leaf.sq_distances(query, sq_distance);
        for (std::size_t k = 0; k < leaf_size; ++k)
          if (sq_distance[k] <= sq_radius) result.push_back({leaf.index[k], sq_distance[k]});
      });
  std::sort(result.begin(), result.end(), nearer);
}

Neighbour KdTree::nearest_one(const Vec3& query) const {
  ensure(tree_->finite > 0, "the nearest of no points does not exist");
  Neighbour one{0, infinity};
  Nearest near(&one, 1);
  tree_->visit(query, [&] { return near.worst(); }, [&](const Leaf& leaf) { near.add(leaf, query); });
  return one;
}

}  // namespace partscribe
