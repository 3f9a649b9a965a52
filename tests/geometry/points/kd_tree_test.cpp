#include "geometry/points/kd_tree.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>

#include "core/random.h"

using namespace partscribe::geometry;

namespace {

/// All points by distance, ties by index; those that are not finite left out.
std::vector<Neighbour> by_hand(const std::vector<Vec3>& points, const Vec3& query) {
  std::vector<Neighbour> all;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const double x = query.x() - points[i].x(), y = query.y() - points[i].y(), z = query.z() - points[i].z();
    if (points[i].allFinite()) all.push_back({i, x * x + y * y + z * z});
  }
  std::sort(all.begin(), all.end(), [](const Neighbour& a, const Neighbour& b) {
    return a.sq_distance != b.sq_distance ? a.sq_distance < b.sq_distance : a.index < b.index;
  });
  return all;
}

template <class A, class B>
bool same(const A& a, const B& b, std::size_t count) {
  return a.size() == std::min(count, b.size()) &&
         std::equal(a.begin(), a.end(), b.begin(), [](const Neighbour& m, const Neighbour& n) {
           return m.index == n.index && m.sq_distance == n.sq_distance;
         });
}

/// Anywhere, on a plane, on a coarse lattice with many equal distances and points twice, or mostly at one place; some
/// are not finite.
std::vector<Vec3> cloud(int kind, std::size_t size) {
  Random random(kind + 10);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < size; ++i) {
    const auto place = [&] { return kind == 2 ? double(random.below(7)) : 2 * random.uniform() - 1; };
    const double x = place(), y = place(), z = place();
    points.emplace_back(x, y, kind == 1 ? 0 : z);
    if (kind == 3 && i % 5 != 2) points.back() = Vec3(0.5, 0.25, 0);
    if (kind == 0 && i % 17 == 3) points.back().y() = std::numeric_limits<double>::quiet_NaN();
  }
  return points;
}

}  // namespace

TEST_CASE("kd tree: every answer is what comparing with all points gives, in the last bit and among equals") {
  for (const int kind : {0, 1, 2, 3})
    for (const std::size_t size :
         {std::size_t(1), std::size_t(15), std::size_t(16), std::size_t(17), std::size_t(500)}) {
      INFO("kind " + std::to_string(kind) + ", " + std::to_string(size) + " points");
      const std::vector<Vec3> points = cloud(kind, size);
      const KdTree tree(points);
      std::vector<Neighbour> near;
      for (const Vec3& place : cloud(kind == 1 ? 1 : 2, 20)) {
        const auto truth = by_hand(points, place);
        for (const std::size_t count : {1, 10, 72}) {
          tree.nearest(place, count, near);
          CHECK(same(near, truth, count));
        }
        CHECK(tree.nearest_one(place).index == truth.front().index);
        for (const double limit : {0.25, 1.0, 1e6}) {
          const auto two = tree.nearest_two(place, limit);
          for (std::size_t k = 0; k < 2; ++k) {
            const bool there = k < truth.size() && truth[k].sq_distance <= limit;
            CHECK((there ? two[k].index == truth[k].index && two[k].sq_distance == truth[k].sq_distance
                         : std::isinf(two[k].sq_distance)));
          }
        }
        tree.within(place, 1.0, near);
        CHECK(same(near, truth, std::size_t(std::count_if(truth.begin(), truth.end(), [](const Neighbour& n) {
                     return n.sq_distance <= 1;
                   }))));
        for (const double radius : {0.0, 0.3, 1.0, 3.0, 1e6}) {
          tree.within(place, radius, near);
          CHECK(tree.count_within(place, radius) == near.size());
        }
      }
      for (const std::size_t count : {1, 10, 30, 450}) {
        std::vector<int> asked(size, 0), wrong(size, 0);
        tree.nearest_of_each(count, 2, [&](std::uint32_t i, std::span<const Neighbour> found) {
          ++asked[i];
          wrong[i] = !same(found, by_hand(points, points[i]), count);
        });
        CHECK(std::count(wrong.begin(), wrong.end(), 1) == 0);
        LargeVector<std::uint32_t> order;
        tree.nearest_of_each(count, 1, [&](std::uint32_t i, std::span<const Neighbour>) { order.push_back(i); });
        CHECK(order == tree.order());
        for (std::size_t i = 0; i < size; ++i) CHECK(asked[i] == int(points[i].allFinite()));
      }
    }
}

TEST_CASE("kd tree: many equal points cost no more than different ones") {
  std::vector<Vec3> points = cloud(1, 10'000);
  points.resize(60'000, Vec3(0.1, 0.2, 0));
  const auto seconds = [](const auto& work) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  const std::vector<Vec3> different = cloud(1, 60'000);
  const auto ask = [](const std::vector<Vec3>& set) {
    const KdTree tree(set);
    std::vector<Neighbour> near;
    std::size_t found = 0;
    for (std::size_t i = 0; i < set.size(); ++i) {
      tree.nearest(set[i], 30, near);
      found += near.size() + tree.nearest_one(set[i]).index % 2;
    }
    tree.nearest_of_each(30, 1, [&](std::uint32_t, std::span<const Neighbour> some) { found += some.size(); });
    CHECK(found >= 60 * set.size());
  };
  // Looking at all equal points for each of them would take minutes.
  const double usual = seconds([&] { ask(different); }), equal = seconds([&] { ask(points); });
  CAPTURE(usual, equal);
  CHECK(equal < 3 * usual + 0.1);
}
