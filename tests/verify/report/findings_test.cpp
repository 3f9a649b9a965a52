/// Claims about findings: features have names and sizes, and what is wrong is said of the right one.
#include <catch2/catch.hpp>

#include "testing/meshes.h"
#include "verify/features/features.h"

using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

constexpr double T = 0.1;
constexpr double sigma = 0.02;

VerifyOptions options() {
  VerifyOptions o;
  o.tolerance = T;
  return o;
}

const MeshFeature* find(const MeshFeatures& features, const std::string& name) {
  for (const auto& f : features.features)
    if (f.name == name) return &f;
  return nullptr;
}

std::string names(const MeshFeatures& features) {
  std::string text;
  for (const auto& f : features.features) text += f.name + " [" + f.kind + "]\n";
  return text;
}

std::string texts(const Verdict& verdict) {
  std::string text;
  for (const auto& f : verdict.artifacts[0].findings) text += std::string(name_of(f.kind)) + ": " + f.text + "\n";
  return text;
}

const FeatureVerdict* row(const Verdict& verdict, const std::string& name) {
  for (const auto& o : verdict.artifacts[0].objects)
    if (o.name == name) return &o;
  return nullptr;
}

const FeatureDimension* dimension(const FeatureVerdict& row, const std::string& name) {
  for (const auto& d : row.dimensions)
    if (d.name == name) return &d;
  return nullptr;
}

std::size_t faults(const Verdict& verdict) {
  std::size_t count = 0;
  for (const auto& f : verdict.artifacts[0].findings) count += f.kind != Finding::Kind::not_scanned;
  return count;
}

}  // namespace

TEST_CASE("findings: a moved hole is one finding that names the hole and the direction") {
  const auto scan = scanned(holed_plate(40, 10, 6, 5, -8), 60000, sigma);
  const auto verdict = verdict_on(holed_plate(40, 10, 6, 5 + 2 * T, -8), scan, options());
  INFO(texts(verdict));
  CHECK(verdict.verdict == Outcome::out_of_tolerance);
  REQUIRE(faults(verdict) >= 1);
  const auto& f = verdict.artifacts[0].findings[0];
  CHECK(f.kind == Finding::Kind::displaced);
  CHECK(f.feature == "hole 1");
  CHECK(f.text.find("hole 1 (diameter 12): centre 0.2 mm too far in +x") != std::string::npos);
  CHECK(f.direction.x() < -0.99);
  CHECK(faults(verdict) == 1);
  const auto* hole = row(verdict, "hole 1");
  REQUIRE(hole);
  REQUIRE(dimension(*hole, "position x"));
  CHECK_FALSE(dimension(*hole, "position x")->within);
  CHECK(dimension(*hole, "position x")->deviation == Approx(-2 * T).margin(0.01));
  CHECK(dimension(*hole, "position y")->within);
  CHECK(dimension(*hole, "diameter")->within);
  CHECK(verdict_table(verdict).find("NOT VERIFIED: hole 1") != std::string::npos);
}

TEST_CASE("findings: a wrong diameter is said with both numbers") {
  const auto scan = scanned(holed_plate(40, 10, 6, 5, -8), 60000, sigma);
  const auto verdict = verdict_on(holed_plate(40, 10, 6.2, 5, -8), scan, options());
  INFO(texts(verdict));
  REQUIRE(faults(verdict) == 1);
  CHECK(verdict.artifacts[0].findings[0].text.find("hole 1 (diameter 12.4): diameter 12.4, the scan says 12") == 0);
}

TEST_CASE("findings: a coarse polygon for a round hole of the same corners is no fault of the diameter") {
  const auto scan = scanned(holed_plate(40, 10, 6, 5, -8, 256), 60000, sigma);
  const auto verdict = verdict_on(holed_plate(40, 10, 6, 5, -8, 32), scan, options());
  INFO(texts(verdict));
  CHECK(verdict.verdict == Outcome::verified);
  const auto* hole = row(verdict, "hole 1");
  REQUIRE(hole);
  CHECK(dimension(*hole, "diameter")->nominal == Approx(12).margin(1e-4));
}

TEST_CASE("findings: a face at the wrong height is named with the way it must move") {
  const auto scan = scanned(holed_plate(40, 10, 6, 5, -8), 60000, sigma);
  const auto verdict = verdict_on(holed_plate(40, 10.3, 6, 5, -8), scan, options());
  INFO(texts(verdict));
  REQUIRE(faults(verdict) >= 1);
  CHECK(verdict.artifacts[0].findings[0].text.find("face +z at 10.3: 0.3 mm too far in +z over") == 0);
}

TEST_CASE("findings: a dent is a patch with its place, depth and area") {
  auto scan = scanned(holed_plate(40, 10, 6, 5, -8), 60000, sigma);
  for (auto& p : scan.cloud.points)
    if (p.z() > 9.5 && std::abs(p.x() + 20) < 3 && std::abs(p.y() - 20) < 3) p.z() -= 0.4;
  const auto verdict = verdict_on(holed_plate(40, 10, 6, 5, -8), scan, options());
  INFO(texts(verdict));
  REQUIRE(faults(verdict) >= 1);
  const auto& f = verdict.artifacts[0].findings[0];
  CHECK(f.feature == "face +z at 10");
  CHECK(f.kind == Finding::Kind::displaced);
  CHECK(f.deviation == Approx(0.4).margin(0.05));
  CHECK(f.area == Approx(36).margin(14));
  CHECK((f.place - Vec3(-20, 20, 10)).norm() < 2);
  CHECK(f.direction.z() < -0.95);
  CHECK(f.text.find("too far in +z") != std::string::npos);
}

TEST_CASE("findings: a filled hole is a missing hole, an invented one an extra hole") {
  const auto holed = holed_plate(40, 10, 6, 5, -8), full = box({-40, -40, 0}, {40, 40, 10});
  const auto missing = verdict_on(full, scanned(holed, 60000, sigma), options());
  INFO(texts(missing));
  CHECK(missing.verdict == Outcome::out_of_tolerance);
  CHECK(texts(missing).find("missing hole: the scan shows a cylindrical wall of diameter 12 about (5, -8,") !=
        std::string::npos);
  const auto extra = verdict_on(holed, scanned(full, 60000, sigma), options());
  INFO(texts(extra));
  CHECK(extra.verdict == Outcome::out_of_tolerance);
  CHECK(texts(extra).find("extra hole 1 (diameter 12)") != std::string::npos);
  CHECK(texts(extra).find("unbroken face there") != std::string::npos);
}

TEST_CASE("findings: a hole in quite another place is one moved hole") {
  const auto verdict =
      verdict_on(holed_plate(40, 10, 6, 20, -8), scanned(holed_plate(40, 10, 6, -15, -8), 60000, sigma), options());
  INFO(texts(verdict));
  CHECK(texts(verdict).find("hole 1 (diameter 12): centre 35 mm too far in +x") != std::string::npos);
}

TEST_CASE("findings: what was not scanned is listed with area and reason, and is no fault") {
  const auto truth = holed_plate(40, 10, 6, 5, -8);
  Scan scan;
  add_view(scan, truth, Vec3(0.2, 0.1, -1).normalized(), 0.4, sigma, 1);
  add_view(scan, truth, Vec3(-0.2, -0.1, -1).normalized(), 0.4, sigma, 2);
  const auto verdict = verdict_on(truth, scan, options());
  INFO(texts(verdict));
  CHECK(faults(verdict) == 0);
  REQUIRE_FALSE(verdict.artifacts[0].findings.empty());
  const auto& f = verdict.artifacts[0].findings[0];
  CHECK(f.kind == Finding::Kind::not_scanned);
  CHECK(f.feature == "face -z at 0");
  CHECK(f.reason == "no view faces it");
  CHECK(f.area > 0.9 * 80 * 80);
}

TEST_CASE("findings: a torn surface is refused with the place where it is open") {
  auto open = holed_plate(40, 10, 6, 5, -8);
  const Vec3 corner = open.corner(0, 0);
  open.triangles.erase(open.triangles.begin());
  const auto verdict = verdict_on(open, scanned(holed_plate(40, 10, 6, 5, -8), 30000, sigma), options());
  CHECK(verdict.verdict == Outcome::out_of_tolerance);
  INFO(all_reasons(verdict) << corner.transpose());
  CHECK(all_reasons(verdict).find("the surface is open: 3 boundary edges, near (") != std::string::npos);
}

TEST_CASE("findings: neighbours of a moved hole are not blamed for it") {
  const auto scan = scanned(holed_plate(40, 10, 6, 5, -8), 60000, sigma);
  const auto verdict = verdict_on(holed_plate(40, 10, 6, 5.5, -8), scan, options());
  INFO(texts(verdict));
  for (const auto& o : verdict.artifacts[0].objects) {
    INFO(o.name);
    CHECK((o.verdict == Outcome::verified) == (o.name != "hole 1"));
  }
}

TEST_CASE("findings: threads and the order of points change nothing") {
  auto scan = scanned(holed_plate(40, 10, 6, 5, -8), 30000, sigma);
  const auto spoiled = holed_plate(40, 10.3, 6.3, 5.2, -8);
  auto text = [&](int threads) {
    auto verdict = verdict_on(spoiled, scan, options(), {}, threads);
    for (auto& a : verdict.artifacts) a.seconds = 0;
    return write_verdict_json(verdict);
  };
  const auto once = text(1);
  CHECK(once.find("\"findings\"") != std::string::npos);
  CHECK(text(2) == once);
  std::reverse(scan.cloud.points.begin(), scan.cloud.points.end());
  CHECK(text(2) == once);
}
