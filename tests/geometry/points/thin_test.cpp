#include "geometry/points/thin.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <string>

#include "core/random.h"

using namespace partscribe::geometry;

namespace {

std::vector<std::uint32_t> by_comparing(const std::vector<Vec3>& points) {
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const Vec3 &p = points[a], &q = points[b];
    return p.x() != q.x() ? p.x() < q.x() : p.y() != q.y() ? p.y() < q.y() : p.z() < q.z();
  });
  return order;
}

std::vector<Vec3> cloud(const std::string& kind, std::size_t size) {
  Random random(7);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < size; ++i) {
    Vec3 p(random.uniform(), random.uniform(), random.uniform());
    const double column = double(i % 60), row = double(i / 60);
    if (kind == "image, rows downwards") p = {0.1 * column, 0.1 * row, p.z()};
    if (kind == "image, rows upwards") p = {0.1 * column, -0.1 * row, p.z()};
    if (kind == "image of three columns") p = {double(i % 3), row, p.z()};
    if (kind == "in one plane") p.x() = 5;
    if (kind == "on one line") p.x() = p.y() = i % 2 ? 0.0 : -0.0;
    if (kind == "in few places") p = {double(random.below(3)), double(random.below(3)), double(random.below(3))};
    if (kind == "far outliers" && i % 1000 == 0) p *= i % 2000 == 0 ? 1e30 : -1e300;
    if (kind == "too far apart" && i < 2) p.x() = i == 0 ? 1.5e308 : -1.5e308;
    points.push_back(p);
  }
  return points;
}

}  // namespace

TEST_CASE("coordinate order: what comparing all coordinates gives, then the index") {
  for (const char* kind : {"anywhere", "image, rows downwards", "image, rows upwards", "image of three columns",
                           "in one plane", "on one line", "in few places", "far outliers", "too far apart"})
    for (const std::size_t size : {0, 1, 50, 1999, 2000, 20000}) {
      INFO(kind << ", " << size << " points");
      const auto points = cloud(kind, size);
      CHECK(coordinate_order(points) == by_comparing(points));
    }
}
