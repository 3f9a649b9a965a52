#include <catch2/catch.hpp>

#include "cli/describe.h"
#include "cli/inputs.h"
#include "cli/report_page.h"
#include "cli/verdict_file.h"

namespace partscribe {
namespace {

Model ball() {
  Model model;
  model.name = "ball <1>";
  model.tolerance = 0.1;
  Parameter radius;
  radius.name = "radius";
  radius.value = 5;
  radius.fitted = 4.99731;
  radius.sigma = 0.0042;
  radius.points = 4120;
  radius.nominal = NominalEvidence{5, 0.64, true, "0.5 mm grid"};
  radius.note = "of the ball";
  model.parameters = {radius};
  Object object;
  object.name = "ball";
  object.shape = Sphere{Expr::of("radius")};
  model.objects = {object};
  model.rivals = {{"ellipsoid", true, 0.02, 312.5, "explains no more and needs two numbers more"}};
  return model;
}

Verdict verdict_with_mesh() {
  Verdict verdict;
  verdict.verdict = Outcome::out_of_tolerance;
  verdict.tolerance = 0.1;
  ArtifactVerdict artifact;
  artifact.file = "part.scad";
  artifact.backend = artifact.program = "openscad";
  artifact.verdict = Outcome::out_of_tolerance;
  artifact.reasons = {"largest local deviation 0.2 mm > 0.1 mm"};
  artifact.objects = {{"ball", 3, 0.1, 0.2, 0.8, Outcome::out_of_tolerance}};
  artifact.mesh.vertices = {{0, 0, 0}, {5, 0, 0}, {0, 5, 0}, {0, 0, 5}};
  artifact.mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  artifact.point_deviation = {0.0f, 0.2f, -0.05f};
  verdict.artifacts = {artifact};
  return verdict;
}

}  // namespace

TEST_CASE("describe: a value carries as many digits as its uncertainty allows") {
  CHECK(with_sigma(10.99731, 0.0042) == "10.9973 ± 0.0042");
  CHECK(with_sigma(123.456, 1.7) == "123.5 ± 1.7");
  CHECK(with_sigma(7, 0) == "7");
}

TEST_CASE("describe: angles are shown in degrees and nominal evidence in words") {
  Parameter angle;
  angle.name = "draft";
  angle.quantity = Quantity::angle;
  angle.value = 0.78539816339744831;
  CHECK(describe(angle).value == "45");
  CHECK(describe(angle).unit == "deg");
  CHECK(describe(ball().parameters.front()).nominal == "5 (0.5 mm grid), 0.64 sigma away: taken");
}

TEST_CASE("describe: a fallback says that it is one") {
  Model model;
  TriSurface surface;
  surface.triangles.resize(724);
  Object object;
  object.name = "surface";
  object.shape = surface;
  model.objects = {object};
  model.fallback = true;
  CHECK(procedure_text(model) == "a triangulation of 724 triangles, because no procedure met 0.1 mm");
}

TEST_CASE("report: base64 agrees with RFC 4648") {
  CHECK(base64("") == "");
  CHECK(base64("f") == "Zg==");
  CHECK(base64("fo") == "Zm8=");
  CHECK(base64("foo") == "Zm9v");
  CHECK(base64("foobar") == "Zm9vYmFy");
}

TEST_CASE("report: the page is self-contained, escaped and says the verdict") {
  const Model model = ball();
  const Verdict verdict = verdict_with_mesh();
  PointCloud cloud;
  cloud.points = {{0, 0, 1}, {1, 0, 0}, {9, 9, 9}, {0, 1, 0}};
  cloud.rejected = {0, 0, 1, 0};
  const auto pictures = draw_report(model, verdict, cloud);
  REQUIRE(pictures.size() == 6);
  const std::string page =
      report_page({model, verdict, cloud, pictures, "part.scad", "if (a < b) cube();", {"unit guessed"}});
  CHECK(page.find("Out of tolerance") != std::string::npos);
  CHECK(page.find("ball &lt;1&gt;") != std::string::npos);
  CHECK(page.find("if (a &lt; b) cube();") != std::string::npos);
  CHECK(page.find("4.9973 ± 0.0042") != std::string::npos);
  CHECK(page.find("needs two numbers more") != std::string::npos);
  CHECK(page.find("unit guessed") != std::string::npos);
  CHECK(page.find("http") == std::string::npos);  // no network
  CHECK(page.find("scope=\"col\"") != std::string::npos);
  std::size_t images = 0, described = 0;
  for (auto at = page.find("<img "); at != std::string::npos; at = page.find("<img ", at + 1)) {
    ++images;
    described += page.find("alt=\"", at) < page.find('>', at);
  }
  CHECK(images == 6);
  CHECK(described == 6);
  CHECK(page == report_page({model, verdict, cloud, pictures, "part.scad", "if (a < b) cube();", {"unit guessed"}}));
}

TEST_CASE("report: deviations belong to kept points, and a wrong number of them is not drawn") {
  const Verdict verdict = verdict_with_mesh();
  PointCloud cloud;
  cloud.points = {{0, 0, 1}, {9, 9, 9}, {1, 0, 0}, {0, 1, 0}};
  cloud.rejected = {0, 1, 0, 0};
  const auto deviations = deviations_of(cloud, &verdict.artifacts.front());
  REQUIRE(deviations.size() == 4);
  CHECK(deviations[0] == 0.0f);
  CHECK(std::isnan(deviations[1]));
  CHECK(deviations[2] == 0.2f);
  cloud.rejected.assign(4, 0);
  CHECK(deviations_of(cloud, &verdict.artifacts.front()).empty());
}

TEST_CASE("verdict file: what was written is read back") {
  const Verdict verdict = verdict_with_mesh();
  const auto back = read_verdict_json(write_verdict_json(verdict), "verdict.json");
  REQUIRE(back.ok());
  CHECK(back->verdict == Outcome::out_of_tolerance);
  CHECK(back->tolerance == 0.1);
  REQUIRE(back->artifacts.size() == 1);
  CHECK(back->artifacts[0].file == "part.scad");
  REQUIRE(back->artifacts[0].objects.size() == 1);
  CHECK(back->artifacts[0].objects[0].max == 0.2);
  const auto bad = read_verdict_json("{\"verdict\": \"fine\"}", "x/verdict.json");
  REQUIRE_FALSE(bad.ok());
  CHECK(bad.error().message.find("x/verdict.json: expected a verdict") == 0);
}

TEST_CASE("inputs: a part is named after its file, or its folder where the file's name says nothing") {
  CHECK(part_name("scans/Pump cover (2).ply") == "pump_cover_2");
  CHECK(part_name("bracket-partscribe/model.json") == "bracket");
  CHECK(part_name("lever/scan/merged.ply") == "lever");
  CHECK(part_name("3mm_plate.stl") == "part_3mm_plate");
}

}  // namespace partscribe
