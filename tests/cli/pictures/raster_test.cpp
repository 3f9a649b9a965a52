#include "cli/pictures/raster.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "cli/pictures/raster_text.h"

namespace partscribe::testing {

using namespace cli;

namespace {

constexpr Color white{255, 255, 255}, red{255, 0, 0}, blue{0, 0, 255};

Camera from_above() { return camera_for({{-1, -1, 0}, {1, 1, 0}}, {0, 0, 1}, {0, 1, 0}, 100, 100); }

Color middle_of(const Raster& raster) { return raster.pixels[50 * 100 + 50]; }

}  // namespace

TEST_CASE("raster: the nearer point hides the farther one, whatever the order") {
  for (const bool swapped : {false, true}) {
    Raster raster(100, 100, white);
    std::vector<Vec3> points = {{0, 0, 1}, {0, 0, -1}};
    std::vector<Color> colors = {red, blue};
    if (swapped) std::swap(points[0], points[1]), std::swap(colors[0], colors[1]);
    draw_points(raster, from_above(), points, colors, 3);
    CHECK(middle_of(raster) == red);
  }
}

TEST_CASE("raster: the camera shows the whole box and keeps up upward") {
  Raster raster(100, 100, white);
  draw_points(raster, from_above(), {{-1, -1, 0}, {1, 1, 0}}, {red, blue}, 2);
  std::size_t red_rows = 0, blue_rows = 0, drawn = 0;
  for (int row = 0; row < 100; ++row)
    for (int column = 0; column < 100; ++column) {
      const Color c = raster.pixels[row * 100 + column];
      if (c == red) {
        red_rows += row, ++drawn;
        CHECK(column < 50);
      }
      if (c == blue) {
        blue_rows += row;
        CHECK(column > 50);
      }
    }
  REQUIRE(drawn > 0);
  CHECK(red_rows > blue_rows);  // y = -1 lies lower in the picture
}

TEST_CASE("raster: triangles cover their silhouette once, and nothing else") {
  const std::vector<Vec3> corners = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  Raster raster(100, 100, white);
  std::size_t painted = 0;
  draw_triangles(raster, from_above(), corners, {{0, 1, 2}, {0, 2, 3}}, [&](std::uint32_t, const Vec3& w, int, int) {
    CHECK(w.sum() == Approx(1));
    ++painted;
    return red;
  });
  std::size_t covered = 0;
  for (const auto& pixel : raster.pixels) covered += pixel == red;
  CHECK(middle_of(raster) == red);
  CHECK(raster.pixels.front() == white);
  CHECK(covered == painted);  // the shared diagonal leaves neither gap nor double
  CHECK(std::abs(static_cast<double>(covered) - 92 * 92) < 2 * 92);
}

TEST_CASE("raster: lines lie on the surface they edge, not on what is nearer") {
  const std::vector<Vec3> corners = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {-1, 0, 0}, {1, 0, 0}};
  for (const bool hidden : {false, true}) {
    Raster raster(100, 100, white);
    const std::vector<Vec3> lid = {{-1, -1, 5}, {1, -1, 5}, {1, 1, 5}, {-1, 1, 5}};
    draw_triangles(raster, from_above(), hidden ? lid : corners, {{0, 1, 2}, {0, 2, 3}},
                   [](std::uint32_t, const Vec3&, int, int) { return red; });
    draw_lines(raster, from_above(), corners, {{4, 5}}, 3, blue);
    CHECK(middle_of(raster) == (hidden ? red : blue));
  }
}

TEST_CASE("raster: every character of numbers and words leaves ink, and different ones different ink") {
  std::vector<std::vector<Color>> seen;
  for (const char c : std::string("0123456789+-ABCDEFGHIJKLMNPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz")) {
    Raster raster(40, 40, white);
    draw_text(raster, 5, 28, 18, std::string(1, c), Color{0, 0, 0});
    INFO(c);
    CHECK(std::count(raster.pixels.begin(), raster.pixels.end(), white) < 40 * 40 - 10);
    CHECK(std::find(seen.begin(), seen.end(), raster.pixels) == seen.end());
    seen.push_back(raster.pixels);
  }
  CHECK(text_width("12", 10) > text_width("1", 10));
}

TEST_CASE("raster: a PNG has the signature, its size and an end") {
  const std::string png = write_png(Raster(7, 3, red));
  CHECK(png.substr(0, 8) == "\x89PNG\r\n\x1a\n");
  CHECK(png.substr(12, 4) == "IHDR");
  CHECK(png[19] == 7);
  CHECK(png[23] == 3);
  CHECK(png.substr(png.size() - 8, 4) == "IEND");
}

TEST_CASE("raster: a contour is drawn where the depth leaps, not where a surface is steep") {
  // From x = -1 to 0 a wall that rises by 12 mm per mm, behind it level ground 6 mm below its upper end.
  const std::vector<Vec3> corners = {{-1, -1, -12}, {0, -1, 0},  {0, 1, 0},  {-1, 1, -12},
                                     {0, -1, -6},   {1, -1, -6}, {1, 1, -6}, {0, 1, -6}};
  Raster raster(100, 100, white);
  draw_triangles(raster, from_above(), corners, {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}},
                 [](std::uint32_t, const Vec3&, int, int) { return blue; });
  const auto per_pixel = raster.depth[50 * 100 + 40] - raster.depth[50 * 100 + 39];
  REQUIRE(per_pixel > 0.1);
  draw_contour(raster, 0.1, 1, red);
  const auto marked = [&](int from, int to) {
    return std::count(raster.pixels.begin() + 50 * 100 + from, raster.pixels.begin() + 50 * 100 + to, red);
  };
  CHECK(marked(15, 45) == 0);
  CHECK(marked(45, 55) == 1);
  CHECK(marked(55, 85) == 0);
}

}  // namespace partscribe::testing
