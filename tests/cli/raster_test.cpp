#include "cli/raster.h"

#include <catch2/catch.hpp>

#include "cli/pictures.h"

namespace partscribe {
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

TEST_CASE("raster: a mesh covers its silhouette and nothing else") {
  TriangleMesh square;
  square.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  Raster raster(100, 100, white);
  draw_mesh(raster, from_above(), square, red);
  CHECK_FALSE(middle_of(raster) == white);
  CHECK(raster.pixels.front() == white);
  // The diagonal is no edge of the shape: no line may run along it.
  CHECK(raster.pixels[40 * 100 + 40] == raster.pixels[45 * 100 + 55]);
}

TEST_CASE("raster: a PNG has the signature, its size and an end") {
  const std::string png = write_png(Raster(7, 3, red));
  CHECK(png.substr(0, 8) == "\x89PNG\r\n\x1a\n");
  CHECK(png.substr(12, 4) == "IHDR");
  CHECK(png[19] == 7);
  CHECK(png[23] == 3);
  CHECK(png.substr(png.size() - 8, 4) == "IEND");
}

TEST_CASE("pictures: a deviation beyond the tolerance looks like none within it") {
  const Color outside = deviation_color(0.11, 0.1);
  CHECK(outside == deviation_color(-5, 0.1));
  for (int k = -10; k <= 10; ++k) CHECK_FALSE(deviation_color(k * 0.01, 0.1) == outside);
  CHECK_FALSE(deviation_color(0.05, 0.1) == deviation_color(-0.05, 0.1));
}

}  // namespace partscribe
