#include "geometry/images/enclosed_by_edges.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

using namespace partscribe::geometry;

namespace {

constexpr int side = 80;

std::size_t at(int x, int y) { return static_cast<std::size_t>(y * side + x); }

struct Scene {
  std::vector<RangeEdge> edges = std::vector<RangeEdge>(std::size_t(side) * side, RangeEdge::none);
  std::vector<double> depth = std::vector<double>(std::size_t(side) * side, 100);

  void line(int x0, int y0, int x1, int y1) {
    const int count = std::max(std::abs(x1 - x0), std::abs(y1 - y0));
    for (int k = 0; k <= count; ++k)
      edges[at(x0 + (x1 - x0) * k / std::max(count, 1), y0 + (y1 - y0) * k / std::max(count, 1))] = RangeEdge::step;
  }
  /// A box whose sides lack `gap` pixels in their middle.
  void box(int x0, int y0, int x1, int y1, int gap) {
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) depth[at(x, y)] = 80;
    const int x = (x0 + x1 - gap) / 2, y = (y0 + y1 - gap) / 2;
    for (const int row : {y0, y1}) line(x0, row, x, row), line(x + gap + 1, row, x1, row);
    for (const int column : {x0, x1}) line(column, y0, column, y), line(column, y + gap + 1, column, y1);
  }
  std::vector<std::uint8_t> outside(const EdgeLinkOptions& options = {}) const {
    return outside_of_edges(edges, depth, side, side, options);
  }
};

int count(const std::vector<std::uint8_t>& marks) { return int(std::count(marks.begin(), marks.end(), 1)); }

}  // namespace

TEST_CASE(
    "enclosed by edges: a box is what its sides enclose, with gaps as long as a bridge, and nothing with longer ones") {
  for (const int gap : {0, 1, 5, 14}) {
    Scene scene;
    scene.box(20, 15, 60, 65, gap);
    INFO("gap " << gap);
    CHECK(count(scene.outside()) == side * side - 41 * 51);
  }
  Scene open;
  open.box(20, 15, 60, 65, 20);
  CHECK(count(open.outside()) == side * side);
}

TEST_CASE(
    "enclosed by edges: the slot between two fingers stays open where its walls have gaps, whatever way it runs") {
  for (const bool turned : {false, true})
    for (const int width : {3, 4, 6}) {
      // Two fingers, `width` pixels of table between them; their walls along the slot lack ten pixels each.
      Scene scene;
      const int left = 38, right = left + width + 1;
      const auto line = [&](int x0, int y0, int x1, int y1) {
        turned ? scene.line(y0, x0, y1, x1) : scene.line(x0, y0, x1, y1);
      };
      for (int y = 10; y <= 70; ++y)
        for (int x = 20; x <= 60; ++x)
          if (x <= left || x >= right || y >= 60) scene.depth[turned ? at(y, x) : at(x, y)] = 80;
      line(20, 10, left, 10), line(right, 10, 60, 10);
      line(20, 10, 20, 70), line(60, 10, 60, 70), line(20, 70, 60, 70);
      for (const int wall : {left, right}) line(wall, 10, wall, 30), line(wall, 41, wall, 60);
      line(left, 60, right, 60);
      const auto outside = scene.outside();
      INFO("width " << width << ", turned " << turned);
      for (int y = 10; y < 59; ++y)
        for (int x = left + 1; x < right; ++x) CHECK(outside[turned ? at(y, x) : at(x, y)] == 1);
      for (int y = 12; y < 69; ++y)
        for (const int x : {left - 2, right + 2}) CHECK(outside[turned ? at(y, x) : at(x, y)] == 0);
    }
}

TEST_CASE("enclosed by edges: specks are not continued, and lines that enclose nothing leave all outside") {
  Scene scene;
  scene.line(10, 10, 12, 10), scene.line(18, 10, 20, 10);
  CHECK(count(linked_steps(scene.edges, side, side, {})) == 6);
  scene.line(10, 40, 30, 40), scene.line(40, 40, 60, 40);
  CHECK(count(linked_steps(scene.edges, side, side, {})) == 6 + 51);
  CHECK(count(scene.outside()) == side * side);
}

TEST_CASE("enclosed by edges: a pixel of the step belongs to the side whose depth it has") {
  Scene scene;
  scene.box(20, 20, 60, 60, 0);
  for (int y = 20; y <= 60; ++y) scene.depth[at(20, y)] = 97;  // seen beside the part
  scene.depth[at(60, 40)] = std::numeric_limits<double>::quiet_NaN();
  const auto outside = scene.outside();
  CHECK(outside[at(20, 40)] == 1);
  CHECK(outside[at(21, 40)] == 0);
  CHECK(outside[at(60, 41)] == 0);
  CHECK(outside[at(60, 40)] == 1);  // nothing was seen
  CHECK(outside[at(61, 41)] == 1);
}
