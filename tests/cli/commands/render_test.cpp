/// render draws what it is given, and the deviation where a scan is given.
#include <catch2/catch.hpp>

#include "testing/png_pixels.h"
#include "testing/program.h"

namespace partscribe::testing {
namespace {

struct Picture {
  int width = 0, height = 0;
  std::size_t drawn = 0;    ///< pixels that are not paper
  std::size_t colored = 0;  ///< clearly coloured ones
};

/// What a picture shows; the program must have ended well.
Picture rendered(std::vector<std::string> arguments, const Path& folder) {
  const Path file = folder / "x.png";
  arguments.insert(arguments.begin(), "render");
  arguments.insert(arguments.end(), {"-o", file.string(), "--force", "--width", "300", "--height", "200"});
  const auto run = run_partscribe(arguments, folder);
  INFO(run.err);
  REQUIRE(run.exit_code == 0);
  const Pixels image = decoded_png(bytes_of(file));
  Picture picture{image.width, image.height};
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    const int r = image.rgb[i], g = image.rgb[i + 1], b = image.rgb[i + 2];
    picture.drawn += r + g + b < 3 * 250;
    picture.colored += std::max({r, g, b}) - std::min({r, g, b}) > 60;
  }
  return picture;
}

}  // namespace

TEST_CASE("render: draws a script, a CAD file, a mesh and a scan, each in the size that was asked for") {
  const TemporaryDirectory folder;
  const Path f = folder.path();
  REQUIRE(write_file(f / "block.scad",
                     "difference() { cube([40, 30, 10]); translate([20, 15, -1]) cylinder(d = 12, h = 12, $fn = 64); }")
              .ok());
  REQUIRE(run_partscribe({"simulate", "block.scad", "--out", "scan", "--resolution", "96"}, f).exit_code == 0);
  const auto script = rendered({"block.scad"}, f);
  CHECK(script.width == 300);
  CHECK(script.height == 200);
  CHECK(script.drawn > 5000);
  CHECK(script.colored == 0);
  const auto above = rendered({"block.scad", "--view", "top"}, f),
             edge = rendered({"block.scad", "--view", "front"}, f),
             own = rendered({"block.scad", "--view", "0,0,1"}, f);
  CHECK(edge.drawn < above.drawn);
  CHECK(own.drawn > 0.95 * above.drawn);
  CHECK(rendered({"scan/scan.json"}, f).drawn > 3000);
}

TEST_CASE("render: a plate is turned until its large face is seen, wherever it faces") {
  const TemporaryDirectory folder;
  const Path f = folder.path();
  for (const char* angle : {"0", "37", "90", "127"}) {  // at 127 degrees it is an edge from the front and right
    INFO(angle);
    REQUIRE(write_file(f / "plate.scad", std::string("rotate(") + angle + ") cube([40, 1, 40], center = true);").ok());
    const auto above = rendered({"plate.scad"}, f);
    CHECK(above.drawn > 8000);
  }
}

TEST_CASE("render: with a scan behind an artifact the picture shows where they differ, and only then") {
  const TemporaryDirectory folder;
  const Path f = folder.path();
  REQUIRE(write_file(f / "true.scad", "cube([40, 30, 10]);").ok());
  REQUIRE(write_file(f / "thick.scad", "cube([40, 30, 10.4]);").ok());
  REQUIRE(run_partscribe({"simulate", "true.scad", "--out", "scan", "--resolution", "96"}, f).exit_code == 0);
  const auto good = rendered({"true.scad", "scan/scan.json", "--tolerance", "0.1"}, f),
             bad = rendered({"thick.scad", "scan/scan.json", "--tolerance", "0.1"}, f);
  CHECK(bad.colored > good.colored + 3000);
}

TEST_CASE("render: what cannot be drawn is refused in one line, and no picture is left") {
  const TemporaryDirectory folder;
  const Path f = folder.path();
  REQUIRE(write_file(f / "wrong.scad", "cube(").ok());
  REQUIRE(write_file(f / "block.scad", "cube(2);").ok());
  for (const auto& [arguments, code] :
       std::vector<std::pair<std::vector<std::string>, int>>{{{"wrong.scad"}, 3},
                                                             {{"none.scad"}, 3},
                                                             {{"none.ply"}, 3},
                                                             {{"block.scad", "--view", "below"}, 2},
                                                             {{"block.scad", "--view", "0,0,0"}, 2},
                                                             {{"block.scad", "--view", "1,2"}, 2},
                                                             {{"block.scad", "block.scad", "x.ply"}, 2}}) {
    auto words = arguments;
    words.insert(words.begin(), "render");
    words.insert(words.end(), {"-o", "x.png", "--quiet"});
    const auto run = run_partscribe(words, f);
    INFO(run.err);
    CHECK(run.exit_code == code);
    CHECK(run.err.find("partscribe: ") != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(f / "x.png"));
  }
}

}  // namespace partscribe::testing
