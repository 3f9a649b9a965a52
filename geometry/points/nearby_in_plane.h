/// Whether any of a fixed set of places in the plane is near.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "geometry/points/kd_tree.h"

namespace partscribe::geometry {

/// Keeps its own copy of the places; queries may run on many threads.
class NearbyInPlane {
 public:
  /// `place`: what of an item is its place (mm), such as a pointer to a member; the item itself if not given.
  template <class Item, class Place = std::identity>
  explicit NearbyInPlane(const std::vector<Item>& items, Place place = {})
      : flat_(std::make_unique<std::vector<Vec3>>()) {
    flat_->reserve(items.size());
    for (const Item& item : items) {
      const Vec2& p = std::invoke(place, item);
      flat_->emplace_back(p.x(), p.y(), 0);
    }
    tree_ = std::make_unique<KdTree>(*flat_);
  }
  /// Nearer than `reach` (mm) to any of them.
  bool within(const Vec2& p, double reach) const {
    return !flat_->empty() && tree_->nearest_one({p.x(), p.y(), 0}).sq_distance < reach * reach;
  }

 private:
  std::unique_ptr<std::vector<Vec3>> flat_;
  std::unique_ptr<KdTree> tree_;
};

}  // namespace partscribe::geometry
