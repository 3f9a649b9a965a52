/// Views with rough poses, as a user brings them together.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/number.h"
#include "core/random.h"
#include "geometry/vec.h"
#include "testing/program.h"

namespace partscribe::testing {
namespace {

/// A scan of the bundled part whose guesses are off by some degrees.
std::string rough_scan(const std::string& part, const Path& folder, const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {"simulate",     source_file("corpus/" + part + "/model.json").string(),
                                        "--resolution", "160",
                                        "--sigma",      "0.02",
                                        "--out",        folder.string(),
                                        "--quiet"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const auto output = run_partscribe(arguments);
  INFO(output.err);
  REQUIRE(output.exit_code == 0);
  return (folder / "scan.json").string();
}

}  // namespace

TEST_CASE("views: from rough poses to one cloud without a point twice") {
  const TemporaryDirectory folder;
  const std::string scan = rough_scan("tie_bar", folder.path() / "scan",
                                      {"--views", "8", "--pose-noise-angle", "3", "--pose-noise-shift", "1"});
  const Path out = folder.path() / "out";
  const auto output = run_partscribe({"scan", scan, "--poses", "guess", "--out", out.string()});
  INFO(output.out << output.err);
  REQUIRE(output.exit_code == 0);
  CHECK(output.out.find("Merged") != std::string::npos);
  const auto poses = nlohmann::json::parse(bytes_of(out / "poses.json"));
  REQUIRE(poses.at("views").size() == 8);
  std::size_t placed = 0;
  for (const auto& view : poses.at("views")) {
    CHECK(view.at("covariance").size() == 6);
    if (view.at("status") == "refused")
      CHECK(view.contains("reason"));
    else
      ++placed;
  }
  CHECK(placed >= 6);
  REQUIRE(poses.at("covariance_between_views").size() == 48);
  CHECK(poses.at("covariance_between_views").back().size() == 48);
  CHECK(poses.at("cloud_sha256") == sha256(bytes_of(out / "cloud.ply")));
}

TEST_CASE("views: what is built from rough poses is verified") {
  const TemporaryDirectory folder;
  const std::string scan = rough_scan("tie_bar", folder.path() / "scan",
                                      {"--views", "8", "--pose-noise-angle", "3", "--pose-noise-shift", "1"});
  const auto output = run_partscribe({"build", scan, "--poses", "guess", "--tolerance", "0.25", "--to", "step", "--out",
                                      (folder.path() / "out").string()});
  INFO(output.out << output.err);
  CHECK(output.exit_code == 0);
  // They stand where they stand in the merged cloud.
  const Path merged = folder.path() / "merged";
  REQUIRE(run_partscribe({"scan", scan, "--poses", "guess", "--out", merged.string()}).exit_code == 0);
  CHECK(nlohmann::json::parse(bytes_of(folder.path() / "out/poses.json")).at("views") ==
        nlohmann::json::parse(bytes_of(merged / "poses.json")).at("views"));
}

TEST_CASE("views: the plan is that of a regular polyhedron, and a part seen all around needs no further view") {
  const auto plan = run_partscribe({"views", "--plan", "dodecahedron", "--json"});
  CHECK(plan.exit_code == 0);
  CHECK(nlohmann::json::parse(plan.out).at("views").size() == 20);
  const std::string scan = source_file("corpus/pin/scan/scan.json").string();
  const auto all = run_partscribe({"views", "--scan", scan});
  CHECK(all.exit_code == 0);
  CHECK(all.out.find("No further view") != std::string::npos);
}

TEST_CASE("views: who says nothing of the part gets an octahedron's six directions, and is scanned from these") {
  const auto plan = run_partscribe({"views", "--json"});
  REQUIRE(plan.exit_code == 0);
  CHECK(plan.out == run_partscribe({"views", "--plan", "octahedron", "--json"}).out);
  CHECK(nlohmann::json::parse(plan.out).at("views").size() == 6);
  const TemporaryDirectory folder;
  const auto scan = nlohmann::json::parse(bytes_of(rough_scan("tie_bar", folder.path() / "scan", {})));
  const auto& views = scan.at("views");
  REQUIRE(views.size() == 6);
  // Sensors look along the third column: of any two of an octahedron's, square to each other or opposite.
  const auto along = [](const nlohmann::json& view, std::size_t k) {
    return view.at("camera_to_world").at(k).at(2).get<double>();
  };
  for (std::size_t a = 0; a < 6; ++a) {
    int opposite = 0;
    for (std::size_t b = 0; b < 6; ++b) {
      double cosine = 0;
      for (std::size_t k = 0; k < 3; ++k) cosine += along(views[a], k) * along(views[b], k);
      if (a != b) CHECK((std::abs(cosine) < 1e-9 || std::abs(cosine + 1) < 1e-9));
      opposite += std::abs(cosine + 1) < 1e-9;
    }
    CHECK(opposite == 1);
  }
}

TEST_CASE("views: where half of the views are missing, more are named") {
  const TemporaryDirectory folder;
  const Path from = source_file("corpus/tie_bar/scan");
  std::filesystem::copy(from, folder.path() / "scan");
  auto json = nlohmann::json::parse(bytes_of(folder.path() / "scan/scan.json"));
  const auto views = json.at("views");
  json["views"] = {views.at(0), views.at(1)};
  REQUIRE(write_file(folder.path() / "scan/scan.json", json.dump()).ok());
  const auto next = run_partscribe({"views", "--scan", (folder.path() / "scan/scan.json").string(), "--json"});
  INFO(next.err);
  CHECK(next.exit_code == 0);
  const auto named = nlohmann::json::parse(next.out).at("views");
  REQUIRE(named.size() >= 2);
  CHECK(named.at(0).at("gain_mm2") > named.at(1).at("gain_mm2"));
}

TEST_CASE("views: one view cannot be registered, and an unknown way of poses is named") {
  const TemporaryDirectory folder;
  REQUIRE(write_file(folder.path() / "a.xyz", "0 0 0\n1 0 0\n0 1 0\n").ok());
  const std::string file = (folder.path() / "a.xyz").string();
  const auto alone = run_partscribe({"scan", file, "--poses", "none", "--units", "mm"}, folder.path());
  CHECK(alone.exit_code == 2);
  CHECK(alone.err.find("several views") != std::string::npos);
  const auto corrected =
      run_partscribe({"scan", file, "--poses", "guess", "--correct-depth", "--units", "mm"}, folder.path());
  CHECK(corrected.exit_code == 2);
  CHECK(corrected.err.find("--correct-depth: expected --poses turntable") != std::string::npos);
  const auto unknown = run_partscribe({"scan", file, "--poses", "somewhere"}, folder.path());
  CHECK(unknown.exit_code == 2);
}

TEST_CASE("views: reference points that several views show bring them together") {
  const TemporaryDirectory folder;
  const geometry::Pose moved{geometry::rotation_of(geometry::Vec3(0.4, -0.2, 1.3)), geometry::Vec3(50, -20, 8)};
  std::string first, second;
  const auto line = [](const geometry::Vec3& p) {
    return core::print_number(p.x()) + "," + core::print_number(p.y()) + "," + core::print_number(p.z()) + "\n";
  };
  for (int i = 0; i < 60; ++i)
    for (int j = 0; j < 60; ++j) {
      const double x = i - 30, y = j - 30;
      const geometry::Vec3 p(x, y, 0.01 * x * x - 0.02 * x * y + 3 * std::sin(0.2 * y));
      (i < 40 ? first : second) += line(i < 40 ? p : moved.inverse() * p);
      if (i >= 30 && i < 40) second += line(moved.inverse() * p);
    }
  std::string table = "view,name,x,y,z\n";
  for (const geometry::Vec3& p : {geometry::Vec3(0, 0, 20), geometry::Vec3(10, 30, 22), geometry::Vec3(-20, 5, 25)}) {
    const std::string name = "ball " + std::to_string(int(p.z()));
    table += "a.xyz," + name + "," + line(p) + "b.xyz," + name + "," + line(moved.inverse() * p);
  }
  REQUIRE(write_file(folder.path() / "a.xyz", first).ok());
  REQUIRE(write_file(folder.path() / "b.xyz", second).ok());
  REQUIRE(write_file(folder.path() / "balls.csv", table).ok());
  const auto scan = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"scan",
                                       (folder.path() / "a.xyz").string(),
                                       (folder.path() / "b.xyz").string(),
                                       "--units",
                                       "mm",
                                       "--fiducials",
                                       (folder.path() / "balls.csv").string(),
                                       "--force",
                                       "--out",
                                       (folder.path() / "out").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_partscribe(arguments);
  };
  // As they say, and where they say as a beginning for registration.
  for (const auto& [more, within] :
       {std::pair<std::vector<std::string>, double>{{}, 1e-6}, {{"--poses", "guess"}, 1}}) {
    const auto output = scan(more);
    INFO(output.out << output.err);
    REQUIRE(output.exit_code == 0);
    const auto poses = nlohmann::json::parse(bytes_of(folder.path() / "out/poses.json")).at("views");
    REQUIRE(poses.size() == 2);
    CHECK(poses.at(0).at("status") == "reference");
    CHECK(poses.at(1).at("status") == "registered");
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c) {
        const double wanted = c < 3 ? moved.rotation(r, c) : moved.translation[r];
        CHECK(std::abs(poses.at(1).at("world_from_view").at(std::size_t(r)).at(std::size_t(c)).get<double>() - wanted) <
              within);
      }
  }
  const auto wrong = scan({"--poses", "none"});
  CHECK(wrong.exit_code == 2);
  CHECK(wrong.err.find("--fiducials: expected no --poses") != std::string::npos);
  REQUIRE(write_file(folder.path() / "balls.csv", "a.xyz,m,1,2,3\nc.xyz,m,1,2,3\n").ok());
  const auto bad = scan({});
  CHECK(bad.exit_code == 3);
  CHECK(bad.err.find("balls.csv: line 2") != std::string::npos);
}

TEST_CASE("views: a part on a table is cut out, and nothing is written when there is none") {
  const TemporaryDirectory folder;
  std::string scene;
  for (int i = 0; i < 90; ++i)
    for (int j = 0; j < 90; ++j) {
      const double x = i - 45, y = j - 45, up = 400 - x * x - y * y;  // a dome of radius 20
      scene += std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(up > 0 ? std::sqrt(up) : 0) + "\n";
    }
  REQUIRE(write_file(folder.path() / "scene.xyz", scene).ok());
  const Path out = folder.path() / "out";
  const auto scan = [&](const char* which) {
    return run_partscribe(
        {"scan", (folder.path() / "scene.xyz").string(), "--units", "mm", "--on-table", which, "--out", out.string()});
  };
  const auto none = scan("2");
  CHECK(none.exit_code == 3);
  CHECK(none.err.find("found 1") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(out));
  const auto dome = scan("1");
  INFO(dome.out << dome.err);
  REQUIRE(dome.exit_code == 0);
  CHECK(dome.out.find("Kept thing 1 of 1") != std::string::npos);
  const auto line = dome.out.find("Points ");
  REQUIRE(line != std::string::npos);
  const int points = std::stoi(dome.out.substr(line + 7));
  CHECK(points > 1000);
  CHECK(points < 1257);  // 400 pi in all

  // Whoever builds the whole scene is told, once that has failed: a crowd in the air, as of a hand in the picture, is
  // no surface that a triangulation follows.
  Random random(4);
  for (int i = 0; i < 600; ++i) {
    for (const double middle : {30, 30, 12}) scene += std::to_string(middle + 3 * random.normal()) + " ";
    scene += "\n";
  }
  REQUIRE(write_file(folder.path() / "room.xyz", scene).ok());
  const Path room = folder.path() / "room.xyz";
  const auto built = run_partscribe({"build", room.string(), "--units", "mm", "--tolerance", "0.5", "--procedure",
                                     "triangulation", "--to", "alpha1", "--out", (folder.path() / "room").string()});
  INFO(built.out << built.err);
  CHECK(built.exit_code == 1);
  CHECK(built.out.find("partscribe scan " + room.string() + " --units mm --on-table 1") != std::string::npos);
}

}  // namespace partscribe::testing
