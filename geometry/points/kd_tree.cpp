#include "geometry/points/kd_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/ensure.h"
#include "core/large_memory.h"
#include "core/parallel.h"
#include "geometry/points/kd_leaves.h"

namespace partscribe::geometry {
namespace {

using Leaf = KdLeaf;
constexpr std::size_t leaf_size = Leaf::size;
constexpr double infinity = std::numeric_limits<double>::infinity();

bool nearer(const Neighbour& a, const Neighbour& b) {
  return a.sq_distance != b.sq_distance ? a.sq_distance < b.sq_distance : a.index < b.index;
}

/// Boxes are looked at in pairs of coordinates: comparisons that the compiler turns into jumps cost half of a search.
typedef double Two __attribute__((vector_size(16)));
inline Two larger(Two a, Two b) { return a > b ? a : b; }
inline Two smaller(Two a, Two b) { return a < b ? a : b; }

/// Of a run of leaves, with the tight box of their points; two halves follow unless it is a single leaf, the left one
/// next.
struct Node {
  Two low_xy, high_xy, low_z, high_z;  // the last of z is zero
  std::uint32_t first, last;           // leaves [first, last)
  std::uint32_t right;
  std::uint32_t least_index;  // of its points: of equally far ones the first are wanted

  bool is_leaf() const { return last - first == 1; }
  /// No point inside is nearer, not even in the last bit: rounding keeps the order of every term and of their sum.
  double sq_distance(Two xy, Two z) const {
    return square(larger(low_xy - xy, xy - high_xy), larger(low_z - z, z - high_z));
  }
  double sq_distance(const Vec3& p) const { return sq_distance(Two{p.x(), p.y()}, Two{p.z(), 0}); }
  double sq_distance(const Node& other) const {
    return square(larger(low_xy - other.high_xy, other.low_xy - high_xy),
                  larger(low_z - other.high_z, other.low_z - high_z));
  }
  /// No point inside is farther, for the same reason.
  double sq_farthest(const Vec3& p) const {
    const Two xy{p.x(), p.y()}, z{p.z(), 0};
    return square(larger(xy - low_xy, high_xy - xy), larger(z - low_z, high_z - z));
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
  std::size_t size() const { return size_; }
  /// True if something at this distance, with an index not below this, may be added.
  bool wants(double sq_distance, std::uint32_t least_index) const {
    return sq_distance < worst_ ||
           (sq_distance == worst_ && (size_ < capacity_ || least_index < list_[size_ - 1].index));
  }

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

inline Two pair_of(const std::array<double, leaf_size>& coordinates, std::size_t k) {
  Two pair;
  std::memcpy(&pair, &coordinates[2 * k], sizeof pair);
  return pair;
}

/// Squared distances of all points of a leaf; returns the least.
double sq_distances(const Leaf& leaf, const Vec3& query, Two* result) {
  const Two x = Two{} + query.x(), y = Two{} + query.y(), z = Two{} + query.z();
  Two least = Two{} + infinity;
  for (std::size_t k = 0; k < leaf_size / 2; ++k) {
    const Two dx = x - pair_of(leaf.x, k), dy = y - pair_of(leaf.y, k), dz = z - pair_of(leaf.z, k);
    result[k] = dx * dx + dy * dy + dz * dz;
    least = result[k] < least ? result[k] : least;
  }
  return least[0] < least[1] ? least[0] : least[1];
}

/// Puts the nearest `count` of the candidates first in the list, nearest first; what follows them there means nothing.
void take_nearest(KdCandidates& c, std::size_t count, std::vector<Neighbour>& list) {
  constexpr std::size_t most_ranked = 400;  // beyond, sorting is faster
  if (list.size() < c.size) list.resize(c.size);
  if (c.size > most_ranked) {
    const auto first = list.begin(), last = first + static_cast<std::ptrdiff_t>(count);
    for (std::size_t k = 0; k < c.size; ++k) list[k] = {c.index[k], c.sq_distance[k]};
    std::nth_element(first, last - 1, first + static_cast<std::ptrdiff_t>(c.size), nearer);
    std::sort(first, last, nearer);
  } else if (rank_candidates(c)) {
    for (std::size_t k = 0; k < c.size; ++k) list[c.place[k]] = {c.index[k], c.sq_distance[k]};
  } else {
    // Equally far ones share a place: they move on to the free ones behind it, and are put in order of their indices.
    constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();
    for (std::size_t k = 0; k < c.size; ++k) list[k].index = nobody;
    for (std::size_t k = 0; k < c.size; ++k) {
      std::size_t at = c.place[k];
      while (list[at].index != nobody) ++at;
      const Neighbour item{c.index[k], c.sq_distance[k]};
      for (; at > c.place[k] && list[at - 1].index > item.index; --at) list[at] = list[at - 1];
      list[at] = item;
    }
  }
}

struct Scratch {
  KdCandidates candidates;
  KdBoxes boxes;         // of leaves near the one that is asked
  double complete = -1;  // squared distance up to which they are all there
  double sq_reach = -1;  // of the point asked last
  std::vector<Neighbour> list;
};

}  // namespace

struct KdTree::Tree {
  std::size_t finite = 0;
  LargeVector<Leaf> leaves;
  LargeVector<Node> nodes;

  struct Item {
    Vec3 point;
    std::uint32_t index;
  };

  explicit Tree(std::span<const Vec3> points) {
    LargeVector<Item> items;
    items.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      if (points[i].allFinite()) items.push_back({points[i], static_cast<std::uint32_t>(i)});
    make_room(items.size());
    if (finite > 0) build(items, 0, leaves.size());
  }

  Tree(std::span<const Vec3> points, std::span<const std::uint32_t> order) {
    LargeVector<Item> items;
    items.reserve(order.size());
    for (const std::uint32_t i : order)
      if (points[i].allFinite()) items.push_back({points[i], i});
    make_room(items.size());
    if (finite > 0) build_in_order(items, 0, leaves.size());
  }

  void make_room(std::size_t count) {
    finite = count;
    leaves.resize((finite + leaf_size - 1) / leaf_size);
    nodes.reserve(2 * leaves.size());
  }

  std::uint32_t build(LargeVector<Item>& items, std::size_t first, std::size_t last) {
    const auto begin = items.begin() + static_cast<std::ptrdiff_t>(first * leaf_size);
    const auto end = items.begin() + static_cast<std::ptrdiff_t>(std::min(last * leaf_size, items.size()));
    Box3 box;
    std::uint32_t least = begin->index;
    for (auto i = begin; i != end; ++i) box.add(i->point), least = std::min(least, i->index);
    const auto own = static_cast<std::uint32_t>(nodes.size());
    Node node;
    node.low_xy = Two{box.low.x(), box.low.y()}, node.high_xy = Two{box.high.x(), box.high.y()};
    node.low_z = Two{box.low.z(), 0}, node.high_z = Two{box.high.z(), 0};
    node.first = static_cast<std::uint32_t>(first), node.last = static_cast<std::uint32_t>(last), node.right = 0;
    node.least_index = least;
    nodes.push_back(node);
    if (last - first == 1) {
      fill(leaves[first], &*begin, &*begin + (end - begin));
      return own;
    }
    Eigen::Index axis = 0;
    box.size().maxCoeff(&axis);
    const std::size_t middle = (first + last) / 2;  // all leaves but the last are full
    std::nth_element(begin, items.begin() + static_cast<std::ptrdiff_t>(middle * leaf_size), end,
                     [axis](const Item& a, const Item& b) {
                       return a.point[axis] != b.point[axis] ? a.point[axis] < b.point[axis] : a.index < b.index;
                     });
    build(items, first, middle);
    const std::uint32_t right = build(items, middle, last);
    nodes[own].right = right;
    return own;
  }

  static void fill(Leaf& leaf, const Item* begin, const Item* end) {
    leaf.x.fill(infinity), leaf.y.fill(infinity), leaf.z.fill(infinity), leaf.index.fill(0);
    std::size_t k = 0;
    for (const Item* i = begin; i != end; ++i, ++k)
      leaf.x[k] = i->point.x(), leaf.y[k] = i->point.y(), leaf.z[k] = i->point.z(), leaf.index[k] = i->index;
  }

  /// Halves of the items as they come; boxes follow from those of the halves.
  std::uint32_t build_in_order(const LargeVector<Item>& items, std::size_t first, std::size_t last) {
    const auto own = static_cast<std::uint32_t>(nodes.size());
    nodes.emplace_back();
    Node node;
    node.first = static_cast<std::uint32_t>(first), node.last = static_cast<std::uint32_t>(last), node.right = 0;
    if (last - first == 1) {
      const Item *begin = &items[first * leaf_size], *end = &items[0] + std::min(last * leaf_size, items.size());
      Box3 box;
      node.least_index = begin->index;
      for (const Item* i = begin; i != end; ++i)
        box.add(i->point), node.least_index = std::min(node.least_index, i->index);
      node.low_xy = Two{box.low.x(), box.low.y()}, node.high_xy = Two{box.high.x(), box.high.y()};
      node.low_z = Two{box.low.z(), 0}, node.high_z = Two{box.high.z(), 0};
      fill(leaves[first], begin, end);
    } else {
      const std::size_t middle = (first + last) / 2;
      build_in_order(items, first, middle);
      node.right = build_in_order(items, middle, last);
      const Node &left = nodes[own + 1], &right = nodes[node.right];
      node.least_index = std::min(left.least_index, right.least_index);
      node.low_xy = smaller(left.low_xy, right.low_xy), node.high_xy = larger(left.high_xy, right.high_xy);
      node.low_z = smaller(left.low_z, right.low_z), node.high_z = larger(left.high_z, right.high_z);
    }
    nodes[own] = node;
    return own;
  }

  /// The nearest of all points of one leaf. Each reaches about as far as the one before, so that is tried first.
  void nearest_of_leaf(std::size_t number, std::size_t count, Scratch& scratch,
                       const std::function<void(std::uint32_t, std::span<const Neighbour>)>& use) const {
    constexpr double margin = 1.2, far = 8;  // of squared distances
    KdCandidates& c = scratch.candidates;
    KdBoxes& boxes = scratch.boxes;
    double &complete = scratch.complete, &sq_reach = scratch.sq_reach;
    auto& list = scratch.list;
    const Leaf& leaf = leaves[number];
    const std::size_t size = std::min(finite - number * leaf_size, leaf_size);
    std::array<double, leaf_size> reaches;  // squared; of the points so far
    complete = -1;
    std::size_t size_found = count;
    for (std::size_t k = 0; k < size; ++k) {
      const Vec3 query(leaf.x[k], leaf.y[k], leaf.z[k]);
      if (k > 0 && query == Vec3(leaf.x[k - 1], leaf.y[k - 1], leaf.z[k - 1])) {
        reaches[k] = reaches[k - 1];
        use(leaf.index[k], std::span(list.data(), size_found));
        continue;
      }
      const auto enough_within = [&](double limit) {
        if (!(limit <= std::numeric_limits<double>::max())) return false;
        if (limit > complete) complete = collect(number, limit, boxes);
        points_within(leaves.data(), boxes, query, limit, c);
        return c.size >= count;
      };
      // A reach of zero is that of equal points, of which there may be very many: a single question stops at enough of
      // them.
      bool found = sq_reach > 0 && enough_within(margin * sq_reach);
      if (!found && k > 0) {
        // What a point of the leaf has found bounds what its neighbours can find.
        double apart[leaf_size];
        leaf.sq_distances(query, apart);
        std::size_t next = 0;
        for (std::size_t j = 1; j < k; ++j) next = apart[j] < apart[next] ? j : next;
        const double bound = std::sqrt(reaches[next]) + std::sqrt(apart[next]);
        const double limit = bound * bound * (1 + 1e-12) + std::numeric_limits<double>::min();
        found = limit < far * reaches[next] && enough_within(limit);
      }
      size_found = count;
      if (found) {
        take_nearest(c, count, list);
      } else {
        if (list.size() < count) list.resize(count);
        Nearest near(list.data(), count);
        visit(
            query, [&](double d, std::uint32_t i) { return near.wants(d, i); },
            [&](const Leaf& other) { near.add(other, query); });
        size_found = near.size();
      }
      reaches[k] = sq_reach = size_found == count ? list[count - 1].sq_distance : infinity;
      use(leaf.index[k], std::span(list.data(), size_found));
    }
  }

  /// All leaves within `sq_distance` of one; returns what they are complete to.
  double collect(std::size_t number, double sq_distance, KdBoxes& result) const {
    sq_distance *= 1.5;  // for the next ones, too
    std::uint32_t own = 0;
    while (!nodes[own].is_leaf()) own = number < nodes[own + 1].last ? own + 1 : nodes[own].right;
    result.clear();
    std::array<std::uint32_t, 64> open;
    std::size_t count_open = 1;
    open[0] = 0;
    while (count_open > 0) {
      const std::uint32_t at = open[--count_open];
      const Node& node = nodes[at];
      if (node.sq_distance(nodes[own]) > sq_distance) continue;
      if (node.is_leaf()) {
        const double low[3] = {node.low_xy[0], node.low_xy[1], node.low_z[0]},
                     high[3] = {node.high_xy[0], node.high_xy[1], node.high_z[0]};
        result.add(low, high, node.first);
      } else {
        open[count_open++] = node.right, open[count_open++] = at + 1;
      }
    }
    result.fill_up();
    return sq_distance;
  }

  /// Calls `use(leaf)` for leaves that are wanted by their distance and least index, the nearer half first.
  template <class Wanted, class Use>
  void visit(const Vec3& query, const Wanted& wanted, const Use& use) const {
    if (nodes.empty()) return;
    struct Open {
      std::uint32_t node;
      double sq_distance;
    };
    std::array<Open, 64> open;  // one for each level at most
    std::size_t count_open = 0;
    Open at{0, nodes[0].sq_distance(query)};
    while (true) {
      const Node& node = nodes[at.node];
      if (wanted(at.sq_distance, node.least_index)) {
        if (!node.is_leaf()) {
          Open left{at.node + 1, nodes[at.node + 1].sq_distance(query)},
              right{node.right, nodes[node.right].sq_distance(query)};
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

KdTree::KdTree(std::span<const Vec3> points) : tree_(std::make_unique<Tree>(points)) {}
KdTree::KdTree(std::span<const Vec3> points, std::span<const std::uint32_t> order)
    : tree_(std::make_unique<Tree>(points, order)) {}
KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;

void KdTree::nearest(const Vec3& query, std::size_t count, std::vector<Neighbour>& result) const {
  result.clear();
  count = std::min(count, tree_->finite);
  if (count == 0) return;
  result.resize(count);
  Nearest near(result.data(), count);
  tree_->visit(
      query, [&](double d, std::uint32_t i) { return near.wants(d, i); },
      [&](const Leaf& leaf) { near.add(leaf, query); });
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

LargeVector<std::uint32_t> KdTree::order() const {
  LargeVector<std::uint32_t> result;
  result.reserve(tree_->leaves.size() * leaf_size);
  for (const Leaf& leaf : tree_->leaves) result.insert(result.end(), leaf.index.begin(), leaf.index.end());
  result.resize(tree_->finite);
  return result;
}

void KdTree::within(const Vec3& query, double radius, std::vector<Neighbour>& result) const {
  result.clear();
  const double sq_radius = std::min(radius * radius, std::numeric_limits<double>::max());
  tree_->visit(
      query, [&](double d, std::uint32_t) { return d <= sq_radius; },
      [&](const Leaf& leaf) {
        double sq_distance[leaf_size];
        leaf.sq_distances(query, sq_distance);
        for (std::size_t k = 0; k < leaf_size; ++k)
          if (sq_distance[k] <= sq_radius) result.push_back({leaf.index[k], sq_distance[k]});
      });
  std::sort(result.begin(), result.end(), nearer);
}

std::size_t KdTree::count_within(const Vec3& query, double radius) const {
  const double sq_radius = std::min(radius * radius, std::numeric_limits<double>::max());
  std::vector<std::uint32_t> open;
  if (tree_->finite > 0) open.push_back(0);
  std::size_t count = 0;
  while (!open.empty()) {
    const std::uint32_t at = open.back();
    const Node& node = tree_->nodes[at];
    open.pop_back();
    if (node.sq_distance(query) > sq_radius) continue;
    if (node.sq_farthest(query) <= sq_radius) {
      count += std::min(node.last * leaf_size, tree_->finite) - node.first * leaf_size;
    } else if (node.is_leaf()) {
      double sq_distance[leaf_size];
      tree_->leaves[node.first].sq_distances(query, sq_distance);
      count += static_cast<std::size_t>(
          std::count_if(sq_distance, sq_distance + leaf_size, [&](double d) { return d <= sq_radius; }));
    } else {
      open.push_back(at + 1), open.push_back(node.right);
    }
  }
  return count;
}

Neighbour KdTree::nearest_one(const Vec3& query) const {
  ensure(tree_->finite > 0, "the nearest of no points does not exist");
  Neighbour one{0, std::numeric_limits<double>::max()};
  const auto wanted = [&](double d, std::uint32_t i) {
    return d < one.sq_distance || (d == one.sq_distance && i < one.index);
  };
  tree_->visit(query, wanted, [&](const Leaf& leaf) {
    Two found[leaf_size / 2];
    const double least = sq_distances(leaf, query, found);
    if (!(least <= one.sq_distance)) return;
    if (least < one.sq_distance) one = {std::numeric_limits<std::uint32_t>::max(), least};
    for (std::size_t k = 0; k < leaf_size; ++k)
      if (found[k / 2][k % 2] == least) one.index = std::min(one.index, leaf.index[k]);
  });
  return one;
}

std::array<Neighbour, 2> KdTree::nearest_two(const Vec3& query, double sq_limit) const {
  constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();
  Neighbour first{nobody, sq_limit}, second{nobody, sq_limit};
  const auto wanted = [&](double d, std::uint32_t i) {
    return d < second.sq_distance || (d == second.sq_distance && i < second.index);
  };
  tree_->visit(query, wanted, [&](const Leaf& leaf) {
    Two found[leaf_size / 2];
    if (!(sq_distances(leaf, query, found) <= second.sq_distance)) return;
    for (std::size_t k = 0; k < leaf_size; ++k) {
      const Neighbour item{leaf.index[k], found[k / 2][k % 2]};
      if (!nearer(item, second)) continue;
      const bool leads = nearer(item, first);
      second = leads ? first : item;
      if (leads) first = item;
    }
  });
  for (Neighbour* n : {&first, &second})
    if (n->index == nobody) *n = {0, infinity};
  return {first, second};
}

}  // namespace partscribe::geometry
