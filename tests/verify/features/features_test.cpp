/// Features of a mesh have names and kinds.
#include "verify/features/features.h"

#include <catch2/catch.hpp>
#include <chrono>

#include "testing/meshes.h"

using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

constexpr double T = 0.1;
constexpr double sigma = 0.02;

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

TEST_CASE("features: 100,000 triangles in less than a second", "[.speed]") {
  for (const auto& mesh : {sphere(50, 159), holed_plate(40, 10, 6, 5, -8, 12000)}) {
    const auto start = std::chrono::steady_clock::now();
    const auto found = recognise_features(mesh, T);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    WARN(mesh.triangles.size() << " triangles, " << found.features.size() << " features, " << seconds << " s");
    CHECK(seconds < 1);
  }
}
