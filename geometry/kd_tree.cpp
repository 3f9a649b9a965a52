#include "geometry/kd_tree.h"

#include <algorithm>
#include <nanoflann.hpp>

#include "core/ensure.h"

namespace partscribe {
namespace {

struct PointsAdaptor {
  const std::vector<Vec3>& points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][static_cast<int>(axis)]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Index = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointsAdaptor>,
                                                  PointsAdaptor, 3, std::uint32_t>;

bool nearer(const Neighbour& a, const Neighbour& b) {
  return a.sq_distance != b.sq_distance ? a.sq_distance < b.sq_distance : a.index < b.index;
}

/// A nanoflann result set: a sorted list in the caller's own vector, ties by index.
struct NearestSet {
  std::vector<Neighbour>& list;
  std::size_t capacity;
  std::size_t size() const { return list.size(); }
  bool full() const { return list.size() == capacity; }
  bool addPoint(double sq_distance, std::uint32_t index) {
    const Neighbour item{index, sq_distance};
    if (full() && !nearer(item, list.back())) return true;
    if (full()) list.pop_back();
    list.insert(std::upper_bound(list.begin(), list.end(), item, nearer), item);
    return true;
  }
  double worstDist() const {
    // One step above the worst, so that an equally far point of lower index is still met.
    return full() ? std::nextafter(list.back().sq_distance, std::numeric_limits<double>::infinity())
                  : std::numeric_limits<double>::max();
  }
};

struct RadiusSet {
  std::vector<Neighbour>& list;
  double sq_radius;
  std::size_t size() const { return list.size(); }
  bool full() const { return true; }
  bool addPoint(double sq_distance, std::uint32_t index) {
    if (sq_distance <= sq_radius) list.push_back({index, sq_distance});
    return true;
  }
  double worstDist() const { return std::nextafter(sq_radius, std::numeric_limits<double>::infinity()); }
};

}  // namespace

struct KdTree::Tree {
  PointsAdaptor adaptor;
  Index index;
  explicit Tree(const std::vector<Vec3>& points)
      : adaptor{points}, index(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {
    index.buildIndex();
  }
};

KdTree::KdTree(const std::vector<Vec3>& points) : tree_(std::make_unique<Tree>(points)) {}
KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;

void KdTree::nearest(const Vec3& query, std::size_t count, std::vector<Neighbour>& result) const {
  result.clear();
  count = std::min(count, tree_->adaptor.points.size());
  if (count == 0) return;
  NearestSet set{result, count};
  tree_->index.findNeighbors(set, query.data(), nanoflann::SearchParams());
}

void KdTree::within(const Vec3& query, double radius, std::vector<Neighbour>& result) const {
  result.clear();
  if (tree_->adaptor.points.empty()) return;
  RadiusSet set{result, radius * radius};
  tree_->index.findNeighbors(set, query.data(), nanoflann::SearchParams());
  std::sort(result.begin(), result.end(), nearer);
}

Neighbour KdTree::nearest_one(const Vec3& query) const {
  ensure(!tree_->adaptor.points.empty(), "the nearest of no points does not exist");
  std::vector<Neighbour> one;
  nearest(query, 1, one);
  return one.front();
}

}  // namespace partscribe
