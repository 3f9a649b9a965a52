#include "geometry/images/pixel_grid.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"
#include "geometry/points/nearest_again.h"
#include "testing/moving_queries.h"

using namespace partscribe::geometry;
using namespace partscribe::testing;

namespace {

struct Image {
  PixelCamera camera;
  std::vector<std::uint32_t> pixels;
  std::vector<Vec3> points;
};

/// A wavy sheet with a step and holes; `beside`: pixels that points may lie beside theirs.
Image image_of(bool pinhole, double beside) {
  Image image;
  image.camera =
      pinhole ? PixelCamera{true, 300, -290, 33.3, 24.7, 70, 50} : PixelCamera{false, 2, -2.1, 33.3, 24.7, 70, 50};
  const PixelCamera& c = image.camera;
  Random random(3);
  for (int row = 0; row < c.height; ++row)
    for (int column = 0; column < c.width; ++column) {
      if (random.uniform(0, 1) < 0.1 || (column - 50) * (column - 50) + (row - 30) * (row - 30) < 60) continue;
      const double z = 200 + 5 * std::sin(0.2 * column) + 0.3 * row + (column > 30 ? 20 : 0) + random.normal() * 0.1;
      const double u = (column + random.uniform(-beside, beside) - c.cx) / c.fx,
                   v = (row + random.uniform(-beside, beside) - c.cy) / c.fy;
      image.pixels.push_back(static_cast<std::uint32_t>(row * c.width + column));
      image.points.push_back(pinhole ? Vec3(u * z, v * z, z) : Vec3(u, v, z));
    }
  return image;
}

/// Beside a point of the image, or anywhere.
Vec3 query_near(const Image& image, double off, Random& random) {
  const Vec3& p = image.points[std::size_t(random.uniform(0, double(image.points.size())))];
  return p + off * Vec3(random.normal(), random.normal(), random.normal());
}

}  // namespace

TEST_CASE("pixel grid: what it says of the nearest is what a tree says, and near the surface it mostly knows") {
  for (const bool pinhole : {true, false})
    for (const double beside : {0.0, 0.4}) {
      const Image image = image_of(pinhole, beside);
      const PixelGrid grid(image.camera, image.pixels, image.points);
      const KdTree tree(image.points);
      Random random(5);
      std::vector<Neighbour> mine, truth;
      for (const double off : {0.2, 2.0, 30.0}) {
        int known = 0;
        for (int k = 0; k < 2000; ++k) {
          const Vec3 query = query_near(image, off, random);
          const auto two = tree.nearest_two(query, 1e30);
          const double limit = k % 2 ? 1.5 : 1e9;
          PixelGrid::Found found;
          if (grid.nearest(query, limit, found)) {
            ++known;
            if (found.first == PixelGrid::nobody) {
              CHECK(std::sqrt(two[0].sq_distance) >= found.others);
              CHECK(found.others > limit);
            } else {
              CHECK((found.first == two[0].index && found.sq_first == two[0].sq_distance));
              CHECK(std::sqrt(two[1].sq_distance) >= found.others * (1 - 1e-12));
            }
          }
          if (grid.nearest(query, 12, mine)) {
            tree.nearest(query, 12, truth);
            CHECK(std::equal(mine.begin(), mine.end(), truth.begin(), truth.end(),
                             [](auto& a, auto& b) { return a.index == b.index && a.sq_distance == b.sq_distance; }));
          }
        }
        if (off < 1 && beside == 0) CHECK(known > 1900);
      }
    }
}

TEST_CASE("pixel grid: behind the sensor and far outside of the image nothing is said") {
  const Image image = image_of(true, 0);
  const PixelGrid grid(image.camera, image.pixels, image.points);
  PixelGrid::Found found;
  for (const Vec3& query :
       {Vec3(0, 0, -200), Vec3(0, 0, 0), Vec3(500, 0, 200), Vec3(0, std::nan(""), 200), Vec3(1e300, 0, 1e-300)})
    CHECK_FALSE(grid.nearest(query, 1, found));
}

TEST_CASE("pixel grid: its order holds every point once, and a tree built by it answers as any other") {
  const Image image = image_of(true, 0);
  const PixelGrid grid(image.camera, image.pixels, image.points);
  std::vector<std::uint32_t> order = grid.order();
  const KdTree by_order(image.points, order), tree(image.points);
  double longest = 0;
  for (std::size_t k = 1; k < order.size(); ++k) {
    const int a = static_cast<int>(image.pixels[order[k - 1]]), b = static_cast<int>(image.pixels[order[k]]),
              w = image.camera.width;
    longest = std::max(longest, std::hypot(a % w - b % w, a / w - b / w));
  }
  CHECK(longest < 25);  // past holes and the outside
  std::sort(order.begin(), order.end());
  for (std::size_t k = 0; k < order.size(); ++k) REQUIRE(order[k] == k);
  CHECK(order.size() == image.points.size());
  Random random(7);
  std::vector<Neighbour> mine, truth;
  for (int k = 0; k < 500; ++k) {
    const Vec3 query = query_near(image, k % 2 ? 1 : 50, random);
    by_order.nearest(query, 7, mine), tree.nearest(query, 7, truth);
    CHECK(std::equal(mine.begin(), mine.end(), truth.begin(), truth.end(),
                     [](auto& a, auto& b) { return a.index == b.index && a.sq_distance == b.sq_distance; }));
    CHECK(by_order.nearest_one(query).index == tree.nearest_one(query).index);
  }
}

TEST_CASE("nearest again: answers stay those of the tree where a grid is asked first") {
  const Image image = image_of(true, 0);
  const PixelGrid grid(image.camera, image.pixels, image.points);
  const KdTree tree(image.points);
  constexpr std::size_t queries = 200;
  NearestAgain again(tree, image.points, queries, &grid);
  Random random(9);
  std::vector<Vec3> places;
  for (std::size_t k = 0; k < queries; ++k) places.push_back(query_near(image, 3, random));
  answers_stay_those_of(tree, again, std::move(places), 0.7, 4, random);
}
