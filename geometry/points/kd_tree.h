/// Nearest points of a fixed set, with ties broken by index so that answers never depend on chance.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/large_memory.h"
#include "geometry/vec.h"

namespace partscribe::geometry {

struct Neighbour {
  std::uint32_t index;
  double sq_distance;  ///< mm^2
};

/// Built once over points that the caller keeps alive; queries may run on many threads. Points that are not finite are
/// nobody's neighbours.
class KdTree {
 public:
  explicit KdTree(std::span<const Vec3> points);
  /// `order`: each index once, so that points side by side in space lie together; the same answers, built in a tenth of
  /// the time.
  KdTree(std::span<const Vec3> points, std::span<const std::uint32_t> order);
  ~KdTree();
  KdTree(KdTree&&) noexcept;

  /// The `count` nearest points (fewer if there are fewer), nearest first.
  void nearest(const Vec3& query, std::size_t count, std::vector<Neighbour>& result) const;
  /// The same for every point of the set, itself among its neighbours, in half the time of as many single questions:
  /// points side by side are asked together. `use(i, neighbours)` is called once for every finite point, on any thread.
  void nearest_of_each(std::size_t count, int threads,
                       const std::function<void(std::uint32_t, std::span<const Neighbour>)>& use) const;
  /// The finite points leaf by leaf, in the order in which nearest_of_each comes to them: neighbours lie together.
  LargeVector<std::uint32_t> order() const;
  /// All points within `radius`, nearest first.
  void within(const Vec3& query, double radius, std::vector<Neighbour>& result) const;
  /// How many points within() would give; fast also where these are very many.
  std::size_t count_within(const Vec3& query, double radius) const;
  /// Index of the nearest point; the set must not be empty.
  Neighbour nearest_one(const Vec3& query) const;
  /// The nearest two points that are not farther than `sq_limit` (finite); at an infinite distance where there are
  /// none.
  std::array<Neighbour, 2> nearest_two(const Vec3& query, double sq_limit) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace partscribe::geometry
