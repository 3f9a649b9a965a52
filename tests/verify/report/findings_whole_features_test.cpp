/// Claims about the first finding: it names the whole feature that must be mended, and how.
#include <catch2/catch.hpp>

#include "testing/meshes.h"
#include "verify/features/features.h"

using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

constexpr double T = 0.1, sigma = 0.02;

VerifyOptions options() {
  VerifyOptions o;
  o.tolerance = T;
  return o;
}

/// The texts of all findings that are faults, a line each.
std::vector<std::string> faults(const Verdict& verdict) {
  std::vector<std::string> texts;
  for (const auto& f : verdict.artifacts[0].findings)
    if (f.kind != Finding::Kind::not_scanned) texts.push_back(f.text);
  return texts;
}

std::string all(const std::vector<std::string>& texts) {
  std::string text;
  for (const auto& t : texts) text += t + "\n";
  return text;
}

/// What the scan says of a dimension of a feature.
double measured(const Verdict& verdict, const std::string& feature, const std::string& dimension) {
  for (const auto& o : verdict.artifacts[0].objects)
    for (const auto& d : o.dimensions)
      if (o.name == feature && d.name == dimension) return d.measured;
  return 0;
}

/// A prism about z whose outline is a regular polygon, with a hole of that many sides through its corners' circle; 0:
/// round.
TriangleMesh polygon_ring(int outer, double outer_radius, int inner, double inner_radius, double height) {
  TriangleMesh mesh;
  const int rays = 4 * outer * (inner > 0 ? inner : 16);
  const auto n = static_cast<std::uint32_t>(rays);
  auto reach = [&](int sides, double radius, int ray) {
    if (sides == 0) return radius;
    const double step = 2 * pi / sides, angle = std::fmod(2 * pi * ray / rays, step);
    return radius * std::cos(step / 2) / std::cos(angle - step / 2);
  };
  for (const double z : {0.0, height})
    for (const bool out : {false, true})
      for (int j = 0; j < rays; ++j) {
        const double a = 2 * pi * j / rays, r = out ? reach(outer, outer_radius, j) : reach(inner, inner_radius, j);
        mesh.vertices.emplace_back(r * std::cos(a), r * std::sin(a), z);
      }
  auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c}), mesh.triangles.push_back({a, c, d});
  };
  for (std::uint32_t j = 0; j < n; ++j) {
    const std::uint32_t k = (j + 1) % n, bi = 0, bo = n, ti = 2 * n, to = 3 * n;
    quad(bi + j, bi + k, bo + k, bo + j), quad(ti + j, to + j, to + k, ti + k);
    quad(bo + j, bo + k, to + k, to + j), quad(bi + k, bi + j, ti + j, ti + k);
  }
  return mesh;
}

bool begins(const std::string& text, const std::string& start) { return text.rfind(start, 0) == 0; }

}  // namespace

TEST_CASE("first finding: a hole that an artifact without it cuts in two is one, and a hole") {
  const TriangleMesh plate = holed_plate(20, 10, 3, 2, -4);
  const Box3 space = plate.bounds();
  const TriangleMesh lower = box(space.low, space.high - Vec3(0, 0, 4));
  Scan mesh;
  mesh.mesh = plate, mesh.cloud.points = plate.vertices, mesh.views.push_back({});
  for (const auto& scan : {mesh, scanned(plate, 60000, sigma)}) {
    const auto verdict = verdict_on(lower, scan, options());
    const auto found = faults(verdict);
    INFO(all(found));
    CHECK(std::count_if(found.begin(), found.end(), [](const std::string& text) {
            return begins(text, "missing hole: the scan shows a cylindrical wall of diameter 6");
          }) == 1);
    CHECK(all(found).find("in the scan") == std::string::npos);
    CHECK(all(found).find("boss") == std::string::npos);
  }
}

TEST_CASE("first finding: equal holes are counted on both sides, and those that the scan lacks are named") {
  const std::vector<StripHole> seven(7, StripHole{1.5});
  auto five = seven;
  five[1].radius = five[4].radius = 0;
  const auto scan = scanned(holed_strip(five, 6, 7), 60000, sigma);
  const auto verdict = verdict_on(holed_strip(seven, 6, 7), scan, options());
  const auto found = faults(verdict);
  INFO(all(found));
  CHECK(verdict.verdict == Outcome::out_of_tolerance);
  REQUIRE(found.size() == 1);
  CHECK(found[0] ==
        "7 holes of diameter 3 in the artifact, 5 in the scan: hole 2 at (12, 0, 3.5) and hole 5 at (48, 0, 3.5) are "
        "invented");
  const auto fewer =
      faults(verdict_on(holed_strip(five, 6, 7), scanned(holed_strip(seven, 6, 7), 60000, sigma), options()));
  INFO(all(fewer));
  REQUIRE(!fewer.empty());
  CHECK(begins(fewer[0], "5 holes of diameter 3 in the artifact, 7 in the scan: the one about ("));
  CHECK(fewer[0].find(" are missing") != std::string::npos);
}

TEST_CASE("first finding: two holes of the artifact are never one hole of the scan") {
  // The scan has one hole between the artifact's two, nearer to the second.
  const auto scan = scanned(holed_strip({{0}, {1.5, -5}, {1.5}}, 8, 7), 60000, sigma);
  const auto verdict = verdict_on(holed_strip({{1.5, 5}, {1.5}, {1.5}}, 8, 7), scan, options());
  const auto found = faults(verdict);
  INFO(all(found));
  CHECK(verdict.verdict == Outcome::out_of_tolerance);
  std::size_t moved = 0, invented = 0;
  for (const auto& text : found) {
    moved += text.find("centre ") != std::string::npos;
    invented += text.find("is invented") != std::string::npos || text.find("extra hole") != std::string::npos;
  }
  CHECK(moved == 1);
  CHECK(invented == 1);
}

TEST_CASE("first finding: a round of another radius is named with both radii, and its neighbours are not blamed") {
  for (const auto& [drawn, true_radius] : {std::pair{3.0, 7.0}, std::pair{7.0, 3.0}}) {
    const auto scan = scanned(rounded_block(30, true_radius, 15, 64), 60000, sigma);
    const auto verdict = verdict_on(rounded_block(30, drawn, 15, 64), scan, options());
    const auto found = faults(verdict);
    INFO(drawn << " drawn\n" << all(found));
    CHECK(verdict.verdict == Outcome::out_of_tolerance);
    REQUIRE(!found.empty());
    CHECK(begins(found[0],
                 "round 1 (radius " + print_number(drawn) + "): radius " + print_number(drawn) + ", the scan says "));
    CHECK(measured(verdict, "round 1", "radius") == Approx(true_radius).margin(0.06));
    CHECK(found.size() == 1);
    for (const auto& row : verdict.artifacts[0].objects) {
      INFO(row.name);
      CHECK((row.verdict == Outcome::verified) == (row.name != "round 1"));
    }
  }
}

TEST_CASE("first finding: a hole of quite another diameter is the same hole") {
  const auto scan = scanned(holed_plate(40, 10, 9, 5, -8), 60000, sigma);
  const auto verdict = verdict_on(holed_plate(40, 10, 3, 5, -8), scan, options());
  const auto found = faults(verdict);
  INFO(all(found));
  REQUIRE(!found.empty());
  CHECK(begins(found[0], "hole 1 (diameter 6): diameter 6, the scan says "));
  CHECK(measured(verdict, "hole 1", "diameter") == Approx(18).margin(0.02));
  CHECK(found.size() == 1);
}

TEST_CASE("first finding: a round hole drawn with too few sides is one finding that says how many and how far off") {
  struct Case {
    double radius;
    int sides;
    const char* text;
  };
  for (const Case& c : {Case{2, 7, "hole 1 (diameter 4): drawn with 7 sides, up to 0.2 mm inside"},
                        Case{2, 5, "hole 1 (diameter 4): drawn with 5 sides, up to 0.38 mm inside"},
                        Case{6, 12, "hole 1 (diameter 12): drawn with 12 sides, up to 0.2 mm inside"}}) {
    const auto scan = scanned(polygon_ring(5, 16, 0, c.radius, 5), 40000, sigma);
    const auto verdict = verdict_on(polygon_ring(5, 16, c.sides, c.radius, 5), scan, options());
    const auto found = faults(verdict);
    INFO(c.sides << " sides\n" << all(found));
    CHECK(verdict.verdict == Outcome::out_of_tolerance);
    REQUIRE(found.size() == 1);
    CHECK(begins(found[0], c.text));
    CHECK(found[0].find(" inside: export it with finer facets, at ") != std::string::npos);
  }
}

TEST_CASE("first finding: six flat walls that the scan shows too are no round hole, nor where they are too far apart") {
  const auto hexagon = scanned(polygon_ring(5, 20, 6, 5, 8), 40000, sigma);
  for (const double drawn : {5.0, 5.4}) {
    const auto verdict = verdict_on(polygon_ring(5, 20, 6, drawn, 8), hexagon, options());
    INFO(all(faults(verdict)));
    CHECK((verdict.verdict == Outcome::verified) == (drawn == 5));
    CHECK(all(faults(verdict)).find("hole") == std::string::npos);
    for (const auto& row : verdict.artifacts[0].objects) CHECK(row.kind != "hole");
  }
}

TEST_CASE("first finding: a countersink is a cone, whichever side lacks it") {
  const auto with = turned({{0, 0}, {15, 0}, {15, 10}, {6, 10}, {3, 7}, {3, 2}, {0, 2}}, 96);
  const auto without = turned({{0, 0}, {15, 0}, {15, 10}, {3, 10}, {3, 2}, {0, 2}}, 96);
  const auto missing = faults(verdict_on(without, scanned(with, 60000, sigma), options()));
  INFO(all(missing));
  REQUIRE(!missing.empty());
  CHECK(begins(missing[0], "missing countersink: the scan shows a conical wall of 90"));
  CHECK(missing[0].find(" degrees, diameter 6") != std::string::npos);
  const auto extra = faults(verdict_on(with, scanned(without, 60000, sigma), options()));
  INFO(all(extra));
  REQUIRE(!extra.empty());
  CHECK(begins(extra[0], "extra cone 1 (90 degrees)"));
}

TEST_CASE("first finding: whole features come before patches, however large") {
  const auto truth = holed_plate(40, 10, 6, 5, -8);
  auto scan = scanned(truth, 60000, sigma);
  for (auto& p : scan.cloud.points)
    if (p.z() > 9.5 && p.x() < -15 && p.y() > 10) p.z() -= 0.6;
  const auto found = faults(verdict_on(holed_plate(40, 10, 6.2, 5, -8), scan, options()));
  INFO(all(found));
  REQUIRE(found.size() >= 2);
  CHECK(begins(found[0], "hole 1 (diameter 12.4): diameter 12.4"));
  for (const auto& text : found) CHECK(text.find("over 0 mm^2") == std::string::npos);
}

TEST_CASE("outliers: as many as are announced are set aside, and counted, a crowd among them is none") {
  const auto rod = turned({{0, 0}, {5, 0}, {5, 20}, {0, 20}}, 128);
  auto scan = scanned(rod, 3000, sigma);
  Random random(4);
  for (int i = 0; i < 800; ++i)
    scan.cloud.points.emplace_back(random.uniform(-12, 12), random.uniform(-12, 12), random.uniform(-6, 26));
  auto judged = options();
  const auto refused = verdict_on(rod, scan, judged);
  INFO(all_reasons(refused));
  CHECK(refused.verdict == Outcome::out_of_tolerance);
  CHECK(all_reasons(refused).find("2 % of the scan may be outliers") != std::string::npos);
  judged.outlier_rate = 0.25;
  const auto told = verdict_on(rod, scan, judged);
  INFO(all_reasons(told));
  CHECK(told.verdict == Outcome::verified);
  CHECK(verdict_table(told).find(" of 3800 points (") != std::string::npos);
  CHECK(verdict_table(told).find("were set aside as outliers") != std::string::npos);
  // A pin of 2 mm that the artifact lacks.
  const auto pin = moved(turned({{0, 0}, {1, 0}, {1, 3}, {0, 3}}, 32), {0, 0, 20});
  for (const auto& p : scanned(pin, 60, sigma, 3).cloud.points) scan.cloud.points.push_back(p);
  const auto crowd = verdict_on(rod, scan, judged);
  INFO(all_reasons(crowd));
  CHECK(crowd.verdict == Outcome::out_of_tolerance);
}

TEST_CASE("outliers: points that crowd on both sides of a face are as far off as each of them is") {
  const auto truth = holed_plate(20, 4, 3, 2, -1);
  auto scan = scanned(truth, 30000, sigma);
  Random random(9);
  for (int i = 0; i < 30; ++i)
    scan.cloud.points.emplace_back(-10 + random.uniform(-0.4, 0.4), 8 + random.uniform(-0.4, 0.4),
                                   4 + (i % 2 ? 0.4 : -0.4) + random.uniform(-0.1, 0.1));
  const auto verdict = verdict_on(truth, scan, options());
  INFO(all_reasons(verdict));
  CHECK(verdict.verdict == Outcome::out_of_tolerance);
  CHECK(verdict.artifacts[0].data_to_model.local_max > T);
  CHECK(all_reasons(verdict).find("mm off the artifact on both sides of it") != std::string::npos);
}
