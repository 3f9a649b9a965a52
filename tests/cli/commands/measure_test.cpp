/// partscribe measure, as a user runs it on files whose truth is known.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "geometry/io/read_geometry.h"
#include "testing/json_schema.h"
#include "testing/meshes.h"
#include "testing/program.h"

namespace partscribe::testing {

namespace {

using Json = nlohmann::json;

const std::vector<std::string> files = {"faces.json", "faces.csv", "features.csv", "faces.png"};

/// Two cells of 30 x 30 x 10 mm side by side, each with a hole of 8 mm in its middle.
TriangleMesh plate() { return holed_strip({{4}, {4}}, 15, 10); }

std::size_t count_of(const Json& faces, const std::string& kind) {
  return static_cast<std::size_t>(
      std::count_if(faces.begin(), faces.end(), [&](const Json& f) { return f["kind"] == kind; }));
}

Json measured(const Path& input, const Path& out, const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = {"measure", input.string(), "--units", "mm", "--out", out.string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const auto run = run_partscribe(arguments);
  INFO(run.out << run.err);
  REQUIRE(run.exit_code == 0);
  for (const auto& file : files) CHECK(std::filesystem::is_regular_file(out / file));
  return Json::parse(bytes_of(out / "faces.json"));
}

double size_of(const Json& feature, const std::string& name) {
  for (const auto& d : feature["dimensions"])
    if (d["name"] == name) return d["value"];
  return -1;
}

/// The six sides and both holes of `plate`, and nothing else.
void check_plate(const Json& json, double tolerance) {
  CHECK(JsonSchema(source_file("docs/faces.schema.json")).fault(json, JsonSchema::Keys::named) == "");
  const auto& faces = json["faces"];
  CHECK(faces.size() == 8);
  CHECK(count_of(faces, "plane") == 6);
  REQUIRE(count_of(faces, "cylinder") == 2);
  for (const auto& face : faces) {
    if (face["kind"] != "cylinder") continue;
    CHECK(face["radius"].get<double>() == Approx(4).margin(tolerance));
    CHECK(face["convex"] == false);
    CHECK(std::abs(face["axis"][2].get<double>()) == Approx(1).margin(1e-3));
    const double x = face["point"][0];
    CHECK(std::min(std::abs(x), std::abs(x - 30)) < tolerance);
    CHECK(face["point"][1].get<double>() == Approx(0).margin(tolerance));
  }
  std::size_t holes = 0;
  for (const auto& feature : json["features"]) {
    if (feature["kind"] != "through hole") continue;
    ++holes;
    CHECK(size_of(feature, "diameter") == Approx(8).margin(2 * tolerance));
    CHECK(size_of(feature, "depth") == Approx(10).margin(tolerance));
    CHECK(feature["place"][1].get<double>() == Approx(0).margin(tolerance));
  }
  CHECK(holes == 2);
}

}  // namespace

TEST_CASE("measure: the mesh of a plate has its six sides and two holes, and nothing is left over") {
  const TemporaryDirectory folder;
  const Path input = folder.path() / "plate.stl";
  REQUIRE(write_file(input, write_stl(plate())).ok());
  const auto json = measured(input, folder.path() / "out");
  check_plate(json, 1e-4);
  CHECK(json["source"] == "mesh");
  CHECK(json["unclassified"].empty());
  CHECK(json["area"].get<double>() == Approx(area(plate())));

  SECTION("the same bytes again, whatever the number of threads") {
    measured(input, folder.path() / "again", {"--threads", "1"});
    for (const auto& file : files)
      CHECK(bytes_of(folder.path() / "out" / file) == bytes_of(folder.path() / "again" / file));
  }
  SECTION("--json FILE and --csv FILE take the tables elsewhere, --json prints them") {
    const Path table = folder.path() / "sheet.csv", copy = folder.path() / "copy.json";
    measured(input, folder.path() / "more", {"--csv", table.string(), "--json", copy.string()});
    CHECK(bytes_of(table) == bytes_of(folder.path() / "out/faces.csv"));
    CHECK(bytes_of(copy) == bytes_of(folder.path() / "out/faces.json"));
    const auto told = run_partscribe(
        {"measure", input.string(), "--units", "mm", "--out", (folder.path() / "told").string(), "--json"});
    CHECK(told.exit_code == 0);
    auto printed = Json::parse(told.out);
    CHECK(printed["files"].size() == 4);
    printed.erase("files"), printed.erase("warnings");
    CHECK(printed == json);
  }
  SECTION("nothing is overwritten without --force") {
    const auto again = run_partscribe({"measure", input.string(), "--out", (folder.path() / "out").string()});
    CHECK(again.exit_code == 2);
    CHECK(again.err.find("faces.json exists already") != std::string::npos);
  }
}

TEST_CASE("measure: a scan of a plate has its six sides and two holes to the noise") {
  const TemporaryDirectory folder;
  const Path input = folder.path() / "plate.xyz";
  std::string text;
  for (const auto& p : scanned(plate(), 40'000, 0.02).cloud.points)
    text += print_number(p.x()) + " " + print_number(p.y()) + " " + print_number(p.z()) + "\n";
  REQUIRE(write_file(input, text).ok());
  const auto json = measured(input, folder.path() / "out");
  check_plate(json, 0.02);
  CHECK(json["source"] == "points");
  CHECK(json["noise"].get<double>() == Approx(0.02).epsilon(0.3));
}

TEST_CASE("measure: a mesh that is a scan, with noise on its corners, is measured by its points") {
  const TemporaryDirectory folder;
  TriangleMesh mesh;
  Random random(3);
  constexpr std::uint32_t side = 81;  // corners, 0.5 mm apart
  for (std::uint32_t i = 0; i < side * side; ++i)
    mesh.vertices.emplace_back(0.5 * (i % side), 0.5 * (i / side), 0.02 * random.normal());
  for (std::uint32_t i = 0; i + side < side * side; ++i) {
    if (i % side + 1 == side) continue;
    mesh.triangles.push_back({i, i + 1, i + side});
    mesh.triangles.push_back({i + 1, i + side + 1, i + side});
  }
  const Path input = folder.path() / "sheet.stl";
  REQUIRE(write_file(input, write_stl(mesh)).ok());
  const auto json = measured(input, folder.path() / "out");
  CHECK(json["source"] == "points");
  REQUIRE(json["faces"].size() == 1);
  CHECK(json["faces"][0]["kind"] == "plane");
  CHECK(json["faces"][0]["rms"].get<double>() == Approx(0.02).epsilon(0.2));
  CHECK(json["faces"][0]["area"].get<double>() == Approx(1600).epsilon(0.1));
}

TEST_CASE("measure: bad input ends with 3 and one line") {
  const TemporaryDirectory folder;
  REQUIRE(write_file(folder.path() / "bad.stl", "no mesh").ok());
  REQUIRE(write_file(folder.path() / "few.xyz", "0 0 0\n90 0 0\n0 90 0\n").ok());
  for (const char* name : {"bad.stl", "missing.ply", "few.xyz"}) {
    const auto run = run_partscribe({"measure", name, "--quiet"}, folder.path());
    INFO(run.err);
    CHECK(run.exit_code == 3);
    CHECK(run.out.empty());
    CHECK(run.err.starts_with("partscribe: "));
    CHECK(std::count(run.err.begin(), run.err.end(), '\n') == 1);
    CHECK_FALSE(std::filesystem::exists(folder.path() / "bad-partscribe"));
  }
}

}  // namespace partscribe::testing
