/// Claims about reading verdict.json back.
#include "cli/verdict_file.h"

#include <catch2/catch.hpp>

namespace partscribe::testing {

using namespace cli;

TEST_CASE("verdict.json: features, their dimensions and the findings survive writing and reading") {
  Verdict verdict;
  verdict.verdict = Outcome::out_of_tolerance;
  verdict.tolerance = 0.1;
  ArtifactVerdict artifact;
  artifact.file = "part.scad";
  artifact.verdict = Outcome::out_of_tolerance;
  FeatureVerdict hole;
  hole.name = "hole 3", hole.kind = "hole", hole.points = 40, hole.max = 0.3, hole.verdict = Outcome::out_of_tolerance;
  FeatureDimension diameter;
  diameter.name = "diameter", diameter.nominal = 6.6, diameter.measured = 6.98, diameter.sigma = 0.01;
  diameter.deviation = 0.38, diameter.within = false;
  FeatureDimension tilt;
  tilt.name = "tilt", tilt.quantity = Quantity::angle, tilt.measured = 0.001;
  hole.dimensions = {diameter, tilt};
  artifact.objects = {hole};
  Finding finding;
  finding.kind = Finding::Kind::missing_material;
  finding.feature = "hole 3", finding.place = {1, 2, 3}, finding.direction = {0, 0, -1}, finding.deviation = 0.19;
  finding.area = 14, finding.extent = 5, finding.points = 12, finding.reason = "because",
  finding.text = "hole 3: wrong";
  artifact.findings = {finding};
  verdict.artifacts = {artifact};

  const auto back = read_verdict_json(write_verdict_json(verdict), "verdict.json");
  REQUIRE(back.ok());
  CHECK(write_verdict_json(*back) == write_verdict_json(verdict));
  const auto& read = back->artifacts[0];
  REQUIRE(read.objects[0].dimensions.size() == 2);
  CHECK(read.objects[0].dimensions[0].measured == 6.98);
  CHECK_FALSE(read.objects[0].dimensions[0].within);
  CHECK(read.objects[0].dimensions[1].quantity == Quantity::angle);
  REQUIRE(read.findings.size() == 1);
  CHECK(read.findings[0].kind == Finding::Kind::missing_material);
  CHECK(read.findings[0].place == Vec3(1, 2, 3));
  CHECK(read.findings[0].text == "hole 3: wrong");

  std::string odd = write_verdict_json(verdict);
  odd.replace(odd.find("missing_material"), 16, "missing_materiel");
  const auto refused = read_verdict_json(odd, "x/verdict.json");
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().message.find("found \"missing_materiel\"") != std::string::npos);
}

}  // namespace partscribe::testing
