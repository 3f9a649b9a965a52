/// Claims about findings: features have names and sizes, and what is wrong is said of the right one.
#include <catch2/catch.hpp>
#include <chrono>

#include "tests/verify/shapes.h"
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

TEST_CASE(
    "features: a plate with a hole of few facets has six faces and one hole of the diameter through its corners") {
  for (const int sectors : {12, 24, 128}) {
    const auto found = recognise_features(holed_plate(40, 10, 6, 5, -8, sectors), T);
    INFO(sectors << "\n" << names(found));
    CHECK(found.features.size() == 7);
    for (const char* name : {"face +z at 10", "face -z at 0", "face +x at 40", "face -y at -40"})
      CHECK(find(found, name));
    const auto* hole = find(found, "hole 1");
    REQUIRE(hole);
    CHECK(hole->kind == "hole");
    CHECK(hole->hollow);
    CHECK(hole->primitive->radius == Approx(6).margin(1e-5));
    CHECK((hole->middle - Vec3(5, -8, 5)).norm() < 1e-5);
    CHECK(hole->arc == Approx(2 * pi).margin(0.02));
    CHECK(hole->high - hole->low == Approx(10));
  }
}

TEST_CASE("features: six flat walls are six faces, not a hole") {
  const auto found = recognise_features(holed_plate(40, 10, 6, 5, -8, 6), T);
  INFO(names(found));
  CHECK_FALSE(find(found, "hole 1"));
}

TEST_CASE("features: a turned part has a boss, a cone and flat ends") {
  const auto found = recognise_features(turned({{0, 0}, {8, 0}, {8, 12}, {4, 20}, {0, 20}}, 40), T);
  INFO(names(found));
  REQUIRE(found.features.size() == 4);
  const auto *boss = find(found, "boss 1"), *cone = find(found, "cone 1");
  REQUIRE(boss);
  REQUIRE(cone);
  CHECK(boss->primitive->radius == Approx(8));
  CHECK(cone->primitive->half_angle == Approx(std::atan(0.5)).margin(1e-6));
  CHECK_FALSE(cone->hollow);
  CHECK(find(found, "face +z at 20"));
}

TEST_CASE("features: spheres and tori are known by their corners") {
  const auto ball = recognise_features(sphere(20, 24), T);
  INFO(names(ball));
  REQUIRE(ball.features.size() == 1);
  CHECK(ball.features[0].kind == "sphere");
  CHECK(ball.features[0].primitive->radius == Approx(20).margin(1e-5));
  // A pill: two half spheres that run smoothly into a cylinder.
  std::vector<Vec2> profile;
  for (int i = 0; i <= 12; ++i)
    profile.emplace_back(i == 0 ? 0 : 5 * std::sin(pi / 2 * i / 12), -5 * std::cos(pi / 2 * i / 12));
  for (int i = 0; i <= 12; ++i)
    profile.emplace_back(i == 12 ? 0 : 5 * std::cos(pi / 2 * i / 12), 20 + 5 * std::sin(pi / 2 * i / 12));
  const auto pill = recognise_features(turned(profile, 48), T);
  INFO(names(pill));
  CHECK(find(pill, "boss 1"));
  CHECK(find(pill, "sphere 1"));
  CHECK(find(pill, "sphere 2"));
  // A disc with a round rim: half a torus.
  std::vector<Vec2> rim = {{0, -3}};
  for (int i = 0; i <= 16; ++i) rim.emplace_back(12 + 3 * std::sin(pi * i / 16), -3 * std::cos(pi * i / 16));
  rim.emplace_back(0, 3);
  const auto disc = recognise_features(turned(rim, 64), T);
  INFO(names(disc));
  bool torus = false;
  for (const auto& f : disc.features)
    if (f.primitive && f.primitive->kind == PrimitiveKind::torus) {
      torus = true;
      CHECK(f.primitive->radius == Approx(12).margin(1e-3));
      CHECK(f.primitive->tube == Approx(3).margin(1e-3));
    }
  CHECK(torus);
}

TEST_CASE("features: a mesh without flat or round faces is one free surface") {
  auto mesh = sphere(20, 40);
  for (auto& v : mesh.vertices) v.z() += 0.002 * v.x() * v.y() + 1.5 * std::sin(v.x() / 5), v.x() *= 1.4;
  const auto found = recognise_features(mesh, T);
  INFO(names(found));
  REQUIRE_FALSE(found.features.empty());
  double free = 0, all = 0;
  for (const auto& f : found.features) {
    all += f.area;
    if (f.kind == "free surface") free += f.area;
  }
  CHECK(free > 0.9 * all);
}

TEST_CASE("features: names do not change with the order of the triangles") {
  auto mesh = holed_plate(40, 10, 6, 5, -8, 24);
  const auto before = names(recognise_features(mesh, T));
  std::reverse(mesh.triangles.begin(), mesh.triangles.end());
  CHECK(names(recognise_features(mesh, T)) == before);
}

TEST_CASE("inspection: the numbers of a true model agree with the scan, and nothing is found") {
  const auto truth = holed_plate(40, 10, 6, 5, -8);
  const auto verdict = verdict_on(truth, scanned(truth, 60000, sigma), options());
  INFO(texts(verdict));
  CHECK(verdict.verdict == Outcome::verified);
  CHECK(faults(verdict) == 0);
  const auto* hole = row(verdict, "hole 1");
  REQUIRE(hole);
  CHECK(hole->kind == "hole");
  const auto *diameter = dimension(*hole, "diameter"), *x = dimension(*hole, "position x"),
             *y = dimension(*hole, "position y");
  REQUIRE(diameter);
  REQUIRE(x);
  REQUIRE(y);
  CHECK(diameter->nominal == Approx(12).margin(1e-4));
  CHECK(std::abs(diameter->deviation) < 5 * diameter->sigma);
  CHECK(diameter->sigma < 0.01);
  CHECK(x->nominal == Approx(5).margin(1e-4));
  CHECK(std::abs(x->deviation) < 5 * x->sigma);
  CHECK(std::abs(y->deviation) < 5 * y->sigma);
  CHECK_FALSE(dimension(*hole, "position z"));
  const auto* top = row(verdict, "face +z at 10");
  REQUIRE(top);
  REQUIRE(dimension(*top, "position z"));
  CHECK(dimension(*top, "position z")->measured == Approx(10).margin(0.005));
}

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

TEST_CASE("features: 100,000 triangles in less than a second", "[.speed]") {
  for (const auto& mesh : {sphere(50, 159), holed_plate(40, 10, 6, 5, -8, 12000)}) {
    const auto start = std::chrono::steady_clock::now();
    const auto found = recognise_features(mesh, T);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    WARN(mesh.triangles.size() << " triangles, " << found.features.size() << " features, " << seconds << " s");
    CHECK(seconds < 1);
  }
}
