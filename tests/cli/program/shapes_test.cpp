/// Every shape from a simulated scan to four verified artifacts, as a user runs it.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/files.h"
#include "core/number.h"
#include "core/random.h"
#include "geometry/io/read_geometry.h"
#include "testing/free_forms.h"
#include "testing/program.h"

namespace partscribe::testing {
namespace {

/// Pixels along a side of a view, and what is asked of the result in mm.
struct Setting {
  const char *resolution, *tolerance;
};
constexpr Setting coarse = {"48", "0.4"}, fine = {"110", "0.1"};

/// Scans the committed model of a part and demands that `build` finds its kind and verifies all four artifacts.
void expect_found(const std::string& part, const std::string& kind, const std::vector<double>& sizes,
                  const Setting& setting = coarse) {
  const TemporaryDirectory folder;
  const Path scan = folder.path() / "scan", out = folder.path() / "out";
  const Path truth = testing::source_file("tests/golden/" + part + "/model.json");
  const auto simulated =
      run_partscribe({"simulate", truth.string(), "--views", "icosahedron", "--resolution", setting.resolution,
                      "--sigma", "0.02", "--bit-error", "0.001", "--out", scan.string()});
  INFO(part << ": " << simulated.out << simulated.err);
  REQUIRE(simulated.exit_code == 0);
  const auto built =
      run_partscribe({"build", (scan / "scan.json").string(), "--tolerance", setting.tolerance, "--out", out.string()});
  INFO(built.out << built.err);
  CHECK(built.exit_code == 0);
  const auto model = nlohmann::json::parse(bytes_of(out / "model.json"));
  CHECK(model.at("objects").back().at("shape").at("kind") == kind);
  CHECK_FALSE(model.at("fallback").get<bool>());
  for (const double size : sizes) {
    // Some parameter holds the true size within three of its own sigmas.
    bool held = false;
    for (const auto& p : model.at("parameters"))
      held |= std::abs(p.at("fitted").get<double>() - size) <= 3 * p.at("sigma").get<double>();
    INFO("size " << size);
    CHECK(held);
  }
  const auto verdict = nlohmann::json::parse(bytes_of(out / "verdict.json"));
  CHECK(verdict.at("verdict") == "verified");
  CHECK(verdict.at("artifacts").size() == 4);
}

/// Moves the control point in the middle of a surface by 2 mm along the normal in the OpenSCAD script: that one is
/// refused, the script as it was is not. There a point moves the surface by a good third of its own way.
void check_moved_point(const nlohmann::json& patch, const Path& out, const Path& scan, const char* tolerance) {
  std::string script = bytes_of(out / "part.scad");
  const auto& net = patch.at("control");
  const auto columns = patch.at("knots_v").size() - patch.at("degree_v").get<std::size_t>() - 1;
  const std::size_t middle = net.size() / columns / 2 * columns + columns / 2;
  const auto point = [&](std::size_t i) { return Vec3(net[i][0], net[i][1], net[i][2]); };
  const auto text = [](const Vec3& p) {
    return "[" + print_number(p.x()) + ", " + print_number(p.y()) + ", " + print_number(p.z()) + "]";
  };
  const Vec3 along_u = point(middle + columns) - point(middle - columns),
             along_v = point(middle + 1) - point(middle - 1);
  const std::string before = text(point(middle));
  const std::string after = text(point(middle) + 2 * along_u.cross(along_v).normalized());
  const auto at = script.find(before);
  REQUIRE(at != std::string::npos);
  REQUIRE(write_file(out / "edited.scad", script.replace(at, before.size(), after)).ok());
  const auto verified = [&](const char* file) {
    return run_partscribe({"verify", (out / file).string(), scan.string(), "--units", "mm", "--tolerance", tolerance});
  };
  CHECK(verified("part.scad").exit_code == 0);
  CHECK(verified("edited.scad").exit_code == 1);
}

}  // namespace

TEST_CASE("shapes: a scanned ball is a sphere") { expect_found("sphere", "sphere", {}); }
TEST_CASE("shapes: a scanned ellipsoid keeps its three half axes") {
  expect_found("ellipsoid", "ellipsoid", {30, 20, 12});
}
TEST_CASE("shapes: a scanned block is a box") { expect_found("box", "box", {60, 40, 25.3}); }
TEST_CASE("shapes: a scanned wedge is a wedge") { expect_found("wedge", "wedge", {}); }
TEST_CASE("shapes: a scanned rod is a cylinder") { expect_found("cylinder", "cylinder", {24, 80}); }
TEST_CASE("shapes: a scanned frustum is a cone") { expect_found("cone", "cone", {40, 10, 35}); }
TEST_CASE("shapes: a scanned ring is a torus") { expect_found("torus", "torus", {}); }
TEST_CASE("shapes: a scanned superellipsoid is one") { expect_found("superellipsoid", "superellipsoid", {}); }
TEST_CASE("shapes: a scanned rounded square ring is a supertoroid") {
  expect_found("supertoroid", "supertoroid", {60, 8, 5});
}
TEST_CASE("shapes: a scanned fillet keeps its legs") { expect_found("fillet", "fillet", {14, 10, 50}); }
TEST_CASE("shapes: a scanned polyhedron is cut from half-spaces") { expect_found("half_spaces", "half_spaces", {}); }
TEST_CASE("shapes: a scanned pin is turned") { expect_found("pin", "revolve", {30, 18, 10}); }
TEST_CASE("shapes: a scanned vase is turned from a free profile") { expect_found("nurbs_vase", "revolve", {}); }
TEST_CASE("shapes: a scanned tie bar is extruded") { expect_found("tie_bar", "extrude", {}); }

TEST_CASE(
    "shapes: an open free form is one trimmed surface in four files, and a control point that was moved is refused") {
  const TemporaryDirectory folder;
  // Touched points with noise, as an .xyz file; a round window in the middle.
  Random random(11);
  std::string points;
  for (int i = 0; i < 24000; ++i) {
    const double x = 70 * random.uniform(), y = 50 * random.uniform();
    if (std::hypot(x - 30, y - 25) < 8) continue;
    const double z = 7 * std::sin(x / 13) * std::cos(y / 16) + 0.02 * random.normal();
    points += print_number(snapped(x, 1e-4)) + " " + print_number(snapped(y, 1e-4)) + " " +
              print_number(snapped(z, 1e-4)) + "\n";
  }
  const Path scan = folder.path() / "hood.xyz", out = folder.path() / "out";
  REQUIRE(write_file(scan, points).ok());
  const auto built =
      run_partscribe({"build", scan.string(), "--units", "mm", "--tolerance", "0.2", "--out", out.string()});
  INFO(built.out << built.err);
  REQUIRE(built.exit_code == 0);
  CHECK(built.out.find("a sheet of 1 B-spline surface with ") != std::string::npos);
  const auto model = nlohmann::json::parse(bytes_of(out / "model.json"));
  const auto& shape = model.at("objects").back().at("shape");
  REQUIRE(shape.at("kind") == "surface_set");
  REQUIRE(shape.at("patches").size() == 1);
  const auto& patch = shape.at("patches")[0];
  CHECK(patch.at("control").size() < 150);
  CHECK(patch.at("trims").back().at("loop") == 1);  // the window, and no other hole
  const auto verdict = nlohmann::json::parse(bytes_of(out / "verdict.json"));
  CHECK(verdict.at("verdict") == "verified");
  CHECK(verdict.at("artifacts").size() == 4);

  check_moved_point(patch, out, scan, "0.2");
}

TEST_CASE("shapes: a closed lump is a body of surfaces in four files, and a control point that was moved is refused") {
  const TemporaryDirectory folder;
  const Path scan = folder.path() / "lump.stl", out = folder.path() / "out";
  REQUIRE(write_file(scan, geometry::write_stl(pebble(40))).ok());
  const auto built =
      run_partscribe({"build", scan.string(), "--units", "mm", "--tolerance", "0.25", "--out", out.string()});
  INFO(built.out << built.err);
  REQUIRE(built.exit_code == 0);
  CHECK(built.out.find("Found: a body of ") != std::string::npos);
  const auto model = nlohmann::json::parse(bytes_of(out / "model.json"));
  const auto& shape = model.at("objects").back().at("shape");
  REQUIRE(shape.at("kind") == "surface_set");
  CHECK(shape.at("closed").get<bool>());
  CHECK(shape.at("patches").size() <= 14);
  const auto verdict = nlohmann::json::parse(bytes_of(out / "verdict.json"));
  CHECK(verdict.at("verdict") == "verified");
  CHECK(verdict.at("artifacts").size() == 4);
  check_moved_point(shape.at("patches")[0], out, scan, "0.25");
}

TEST_CASE("shapes: every one of them is found in a fine scan, within a tenth of a millimetre", "[.statistics]") {
  expect_found("sphere", "sphere", {}, fine);
  expect_found("ellipsoid", "ellipsoid", {30, 20, 12}, fine);
  expect_found("box", "box", {60, 40, 25.3}, fine);
  expect_found("wedge", "wedge", {}, fine);
  expect_found("cylinder", "cylinder", {24, 80}, fine);
  expect_found("cone", "cone", {40, 10, 35}, fine);
  expect_found("torus", "torus", {}, fine);
  expect_found("superellipsoid", "superellipsoid", {}, fine);
  expect_found("supertoroid", "supertoroid", {60, 8, 5}, fine);
  expect_found("fillet", "fillet", {14, 10, 50}, fine);
  expect_found("half_spaces", "half_spaces", {}, fine);
  expect_found("pin", "revolve", {30, 18, 10}, fine);
  expect_found("nurbs_vase", "revolve", {}, fine);
  expect_found("tie_bar", "extrude", {}, fine);
}

}  // namespace partscribe::testing
