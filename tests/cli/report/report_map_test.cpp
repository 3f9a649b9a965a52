#include "cli/report/report_map.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "cli/report/report_points.h"
#include "core/random.h"
#include "geometry/mesh/mesh_distance.h"
#include "testing/program.h"
#include "verify/evaluate/evaluate.h"

namespace partscribe::testing {

using namespace cli;

namespace {

/// A plate of 40 x 20 x 2 mm as twelve triangles.
TriangleMesh plate() {
  TriangleMesh mesh;
  for (int k = 0; k < 8; ++k) mesh.vertices.push_back({k & 1 ? 40.0 : 0.0, k & 2 ? 20.0 : 0.0, k & 4 ? 2.0 : 0.0});
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// Its upper face scanned with a hump of 0.3 mm in one corner; feature 0 is that face, feature 1 the rest.
struct ScannedPlate {
  Verdict verdict;
  PointCloud cloud;
  ScannedPlate() {
    ArtifactVerdict artifact;
    artifact.file = "plate.stl";
    artifact.mesh = plate();
    artifact.objects.resize(2);
    artifact.objects[0].name = "top", artifact.objects[1].name = "rest";
    for (std::size_t t = 0; t < 12; ++t) artifact.triangle_object.push_back(t == 2 || t == 3 ? 0 : 1);
    Random random(3);
    for (int i = 0; i < 20000; ++i) {
      const Vec3 p(random.uniform(0, 40), random.uniform(0, 20), 2);
      const double hump = 0.3 * std::exp(-((p - Vec3(35, 15, 2)).squaredNorm()) / 8);
      cloud.points.push_back(p + Vec3(0, 0, hump));
      artifact.point_deviation.push_back(static_cast<float>(hump));
      artifact.point_object.push_back(0);
    }
    artifact.data_to_model.points = cloud.size();
    artifact.data_to_model.local_max = 0.31;
    // The samples run over the triangles in order, so that those of the upper face are the second group.
    const double total = area(artifact.mesh);
    double passed = 0;
    for (std::size_t t = 0; t < 12; ++t) {
      passed += t < 4 ? 400 : t < 8 ? 40 : 20;
      while (static_cast<double>(artifact.sample_support.size()) + 0.5 <= passed / total * 6000)
        artifact.sample_support.push_back(t == 2 || t == 3 ? 0 : 1);
    }
    verdict.tolerance = 0.1;
    verdict.verdict = Outcome::out_of_tolerance;
    verdict.artifacts = {artifact};
  }
};

}  // namespace

TEST_CASE("report map: the coloured surface is the evaluated one, cut finer") {
  const ScannedPlate part;
  Context context;
  const auto scene = report_scene(std::nullopt, part.verdict, part.cloud, context);
  const auto& surface = scene.surface;
  REQUIRE_FALSE(surface.empty());
  CHECK(surface.points.size() <= 65535);
  CHECK(surface.error == 0);
  TriangleMesh drawn{surface.points, surface.triangles};
  CHECK(area(drawn) == Approx(area(plate())));
  CHECK(volume(drawn) == Approx(1600));
  CHECK(topology(welded(drawn, 0)).closed());  // no cracks along creases and between features
  CHECK(surface.edges.size() == 12);
}

TEST_CASE("report map: a ball that was read as many narrow triangles shows no creases") {
  const TemporaryDirectory folder;
  const auto model = source_file("tests/golden/sphere/model.json").string();
  REQUIRE(run_partscribe({"emit", model, "--to", "step", "--out", folder.path().string()}).exit_code == 0);
  Context context;
  auto evaluation = verify::evaluate_artifact(folder.path() / "part.step", {}, context);
  REQUIRE(evaluation.ok());
  ArtifactVerdict ball;
  ball.mesh = std::move(evaluation->mesh);
  const PointCloud none;
  const auto scene = plain_scene(ball, none, {}, context);
  CHECK(scene.surface.error > 0);
  CHECK(scene.surface.edges.empty());
}

TEST_CASE("report map: every artifact that was judged has a map, the others with less detail") {
  ScannedPlate part;
  ArtifactVerdict other = part.verdict.artifacts[0], not_run;
  other.file = "plate.step", not_run.file = "plate.scad";
  for (auto& d : other.point_deviation) d *= 0.5f;
  other.data_to_model.local_max *= 0.5;
  part.verdict.artifacts.insert(part.verdict.artifacts.end(), {not_run, other});
  Context context;
  const auto scene = report_scene(std::nullopt, part.verdict, part.cloud, context);
  CHECK(scene.artifact->file == "plate.stl");
  REQUIRE(scene.others.size() == 1);
  CHECK(scene.others[0].artifact->file == "plate.step");
  CHECK(scene.others[0].others.empty());
  CHECK(map_data(scene, {1000}).shown <= 1000);
  const auto map = map_data(scene.others[0], {1000});
  CHECK(map.shown <= 600);
  CHECK(map.shown > 300);
  const auto largest = [](const std::vector<float>& values) { return *std::max_element(values.begin(), values.end()); };
  CHECK(largest(scene.others[0].surface.deviation) == Approx(0.5 * largest(scene.surface.deviation)).epsilon(0.1));
}

TEST_CASE("report map: a vertex bears its place's deviation, support and feature") {
  const ScannedPlate part;
  Context context;
  const auto scene = report_scene(std::nullopt, part.verdict, part.cloud, context);
  const auto& s = scene.surface;
  double largest = 0;
  std::size_t top = 0;
  for (const auto& triangle : s.triangles)
    for (const auto v : triangle) {
      REQUIRE(s.feature[v] >= 0);
      const bool above = s.normals[v].z() > 0.9;
      CHECK((s.feature[v] == 0) == above);
      if (!above) {
        CHECK(s.support[v] == 1);
        continue;
      }
      ++top;
      const double truth = 0.3 * std::exp(-((s.points[v] - Vec3(35, 15, 2)).squaredNorm()) / 8);
      if (s.support[v] == 0) CHECK(std::abs(s.deviation[v] - truth) < 0.06);
      largest = std::max(largest, static_cast<double>(s.deviation[v]));
    }
  CHECK(top > 1000);
  CHECK(largest > 0.27);
}

TEST_CASE("report map: points are left out where they say the same, and the extremes stay") {
  const ScannedPlate part;
  const auto& values = part.verdict.artifacts[0].point_deviation;
  const auto shown = shown_points(part.cloud.points, values, 0.1, 1500);
  CHECK(shown.index.size() <= 1500);
  CHECK(shown.index.size() > 1200);
  CHECK(shown.of == 20000);
  std::size_t near_hump = 0;
  float highest = 0, present = 0;
  for (const auto v : values) highest = std::max(highest, v);
  for (const auto i : shown.index) {
    near_hump += (part.cloud.points[i] - Vec3(35, 15, 2)).norm() < 5;
    present = std::max(present, values[i]);
  }
  CHECK(present == highest);
  // A tenth of the face, but several times its share of the points.
  CHECK(near_hump > 2 * shown.index.size() * 79 / 800);
  // Each point left out has one close by that is shown and says nearly the same.
  for (std::size_t i = 0; i < part.cloud.size(); i += 7) {
    bool stood_for = false;
    for (const auto k : shown.index)
      stood_for = stood_for || ((part.cloud.points[i] - part.cloud.points[k]).norm() <= shown.distance &&
                                std::abs(values[i] - values[k]) <= shown.value_error + 1e-7);
    CHECK(stood_for);
  }
}

TEST_CASE("report map: which points are shown does not depend on their order") {
  const ScannedPlate part;
  auto points = part.cloud.points;
  auto values = part.verdict.artifacts[0].point_deviation;
  auto places = [&] {
    std::set<std::array<double, 3>> set;
    for (const auto i : shown_points(points, values, 0.1, 900).index)
      set.insert({points[i].x(), points[i].y(), points[i].z()});
    return set;
  };
  const auto before = places();
  std::reverse(points.begin(), points.end());
  std::reverse(values.begin(), values.end());
  CHECK(places() == before);
}

TEST_CASE("report map: few points are all shown, none at all give an empty map") {
  const auto shown = shown_points({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0.1f, std::nanf(""), 0.2f}, 0.1, 100);
  CHECK(shown.index == std::vector<std::uint32_t>{0, 2});
  CHECK(shown.value_error == 0);
  CHECK(shown_points({}, {}, 0.1, 100).index.empty());
}

TEST_CASE("report map: the packed numbers stay within indices that sixteen bits hold") {
  const ScannedPlate part;
  Context context;
  const auto scene = report_scene(std::nullopt, part.verdict, part.cloud, context);
  const auto map = map_data(scene, {.most_points = 2000});
  CHECK(map.shown <= 2000);
  CHECK(map.of == 20000);
  const auto json = nlohmann::json::parse(map.json);
  CHECK(json.at("features") == nlohmann::json({"top", "rest"}));
  CHECK(json.at("views").size() == 7);
  CHECK(json.at("surface").at("places").get<std::string>().size() == (scene.surface.points.size() * 8 + 2) / 3 * 4);
  CHECK(map.json.size() < 1'500'000);
}

}  // namespace partscribe::testing
