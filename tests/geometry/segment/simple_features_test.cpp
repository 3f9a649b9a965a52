/// Claims about holes, slots, bosses, rounds, chamfers, walls and patterns of holes, on meshes and on faces by hand.
#include "geometry/segment/simple_features.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "testing/faces.h"
#include "testing/meshes.h"

namespace partscribe::testing {
namespace {

using Quantity = FeatureSize::Quantity;

std::vector<SimpleFeature> features_of_mesh(const TriangleMesh& mesh) {
  Context context;
  return simple_features(faces_of_mesh(mesh, {}, context));
}

std::vector<SimpleFeature> of_kind(const std::vector<SimpleFeature>& features, const std::string& kind) {
  std::vector<SimpleFeature> found;
  std::copy_if(features.begin(), features.end(), std::back_inserter(found),
               [&](const SimpleFeature& f) { return f.kind == kind; });
  return found;
}

SimpleFeature the_one(const std::vector<SimpleFeature>& features, const std::string& kind) {
  const auto found = of_kind(features, kind);
  std::string kinds;
  for (const auto& f : features) kinds += f.kind + ", ";
  INFO("among " + kinds);
  REQUIRE(found.size() == 1);
  return found.front();
}

const FeatureSize& size_of(const SimpleFeature& feature, const std::string& name) {
  static const FeatureSize none{"none", Quantity::length, -1, -1};
  for (const auto& d : feature.dimensions)
    if (d.name == name) return d;
  FAIL(feature.kind + " has no " + name);
  return none;
}

double value_of(const SimpleFeature& feature, const std::string& name) { return size_of(feature, name).value; }

/// A prism over an outline (counter-clockwise) that is seen whole from `centre`.
TriangleMesh prism(const std::vector<Vec2>& outline, const Vec2& centre, double height) {
  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(outline.size());
  for (const double z : {0.0, height})
    for (const auto& p : outline) mesh.vertices.emplace_back(p.x(), p.y(), z);
  mesh.vertices.emplace_back(centre.x(), centre.y(), 0), mesh.vertices.emplace_back(centre.x(), centre.y(), height);
  for (std::uint32_t j = 0; j < n; ++j) {
    const std::uint32_t k = (j + 1) % n;
    mesh.triangles.push_back({j, k, n + k}), mesh.triangles.push_back({j, n + k, n + j});
    mesh.triangles.push_back({2 * n, k, j}), mesh.triangles.push_back({2 * n + 1, n + j, n + k});
  }
  return mesh;
}

/// A plate 2 `half` wide, along x half as much again, with an opening about its middle: `radius` by angle.
template <class Radius>
TriangleMesh plate_with_opening(std::vector<double> angles, Radius&& radius, double half, double thickness) {
  for (const double cx : {-1.5 * half, 1.5 * half})
    for (const double cy : {-half, half}) angles.push_back(std::atan2(cy, cx));
  for (auto& a : angles) a = std::remainder(a, 2 * pi);
  std::sort(angles.begin(), angles.end());
  angles.erase(std::unique(angles.begin(), angles.end(), [](double a, double b) { return std::abs(a - b) < 1e-9; }),
               angles.end());
  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(angles.size());
  for (const double z : {0.0, thickness})
    for (const bool outer : {false, true})
      for (const double a : angles) {
        const Vec2 d(std::cos(a), std::sin(a));
        const double t = outer ? 1 / std::max(std::abs(d.x()) / (1.5 * half), std::abs(d.y()) / half) : radius(a);
        mesh.vertices.emplace_back(t * d.x(), t * d.y(), z);
      }
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c}), mesh.triangles.push_back({a, c, d});
  };
  for (std::uint32_t j = 0; j < n; ++j) {
    const std::uint32_t k = (j + 1) % n, bi = 0, bo = n, ti = 2 * n, to = 3 * n;
    quad(bi + j, bi + k, bo + k, bo + j), quad(ti + j, to + j, to + k, ti + k);
    quad(bo + j, bo + k, to + k, to + j), quad(bi + k, bi + j, ti + j, ti + k);
  }
  return mesh;
}

}  // namespace

TEST_CASE("simple features: a hole through a plate has its diameter and depth, the plate its thickness", "[segment]") {
  const auto features = features_of_mesh(holed_plate(40, 12, 5, 0, 0));
  const auto hole = the_one(features, "through hole");
  CHECK(hole.name == "hole 1");
  CHECK(value_of(hole, "diameter") == Approx(10).margin(1e-6));
  CHECK(value_of(hole, "depth") == Approx(12).margin(1e-6));
  CHECK(hole.faces.size() == 1);
  CHECK(value_of(the_one(features, "wall"), "thickness") == Approx(12).margin(1e-6));
  CHECK(features.size() == 2);  // the long sides are no wall, nor is the outline anything
}

TEST_CASE("simple features: a blind hole ends at its shoulder, with or without the point of a drill", "[segment]") {
  const double tip = 4 / std::tan(radians(59));
  for (const bool pointed : {false, true}) {
    // Down through the top of a round block: its bottom first.
    std::vector<Vec2> profile = {{0, 0}, {30, 0}, {30, 40}, {4, 40}, {4, 15}, {0, pointed ? 15 - tip : 15}};
    const auto hole = the_one(features_of_mesh(turned(profile, 96)), "blind hole");
    CHECK(value_of(hole, "diameter") == Approx(8).margin(1e-6));
    CHECK(value_of(hole, "depth") == Approx(25).margin(1e-6));
    CHECK(hole.dimensions.size() == (pointed ? 3 : 2));
    if (pointed) CHECK(degrees(value_of(hole, "tip angle")) == Approx(118).margin(0.01));
  }
}

TEST_CASE("simple features: the head of a screw has room in a counterbore or in a countersink", "[segment]") {
  // A ring is turned as a closed profile about an axis that it does not meet: here the bore is closed far below.
  const std::vector<Vec2> bored = {{0, 0}, {30, 0}, {30, 40}, {9, 40}, {9, 33}, {4, 33}, {4, 10}, {0, 10}};
  const auto counterbored = the_one(features_of_mesh(turned(bored, 96)), "counterbored hole");
  CHECK(value_of(counterbored, "diameter") == Approx(8).margin(1e-6));
  CHECK(value_of(counterbored, "depth") == Approx(30).margin(1e-6));
  CHECK(value_of(counterbored, "counterbore diameter") == Approx(18).margin(1e-6));
  CHECK(value_of(counterbored, "counterbore depth") == Approx(7).margin(1e-6));
  CHECK(counterbored.faces.size() == 2);

  const std::vector<Vec2> sunk = {{0, 0}, {30, 0}, {30, 40}, {8, 40}, {4, 36}, {4, 10}, {0, 10}};
  const auto countersunk = the_one(features_of_mesh(turned(sunk, 96)), "countersunk hole");
  CHECK(value_of(countersunk, "diameter") == Approx(8).margin(1e-6));
  CHECK(value_of(countersunk, "depth") == Approx(30).margin(1e-6));
  CHECK(value_of(countersunk, "countersink diameter") == Approx(16).margin(1e-4));
  CHECK(degrees(value_of(countersunk, "countersink angle")) == Approx(90).margin(1e-3));

  // What only takes the edge off is a chamfer, and the hole is as deep as without it.
  const std::vector<Vec2> broken = {{0, 0}, {30, 0}, {30, 40}, {4.5, 40}, {4, 39.5}, {4, 10}, {0, 10}};
  const auto features = features_of_mesh(turned(broken, 96));
  CHECK(value_of(the_one(features, "blind hole"), "depth") == Approx(30).margin(1e-6));
  const auto chamfer = the_one(features, "chamfer");
  CHECK(value_of(chamfer, "width") == Approx(0.5).margin(1e-4));
  CHECK(degrees(value_of(chamfer, "angle")) == Approx(45).margin(0.01));
}

TEST_CASE("simple features: a boss stands on a plane at one end", "[segment]") {
  const std::vector<Vec2> profile = {{0, 0}, {40, 0}, {40, 10}, {8, 10}, {8, 34}, {0, 34}};
  const auto features = features_of_mesh(turned(profile, 96));
  const auto boss = the_one(features, "boss");
  CHECK(value_of(boss, "diameter") == Approx(16).margin(1e-6));
  CHECK(value_of(boss, "height") == Approx(24).margin(1e-6));
  // A neck between two flanges stands on both, and is none.
  const std::vector<Vec2> neck = {{0, 0}, {40, 0}, {40, 10}, {8, 10}, {8, 34}, {40, 34}, {40, 44}, {0, 44}};
  CHECK(of_kind(features_of_mesh(turned(neck, 96)), "boss").empty());
}

TEST_CASE("simple features: a slot has the length of its bed, its width and depth", "[segment]") {
  // Half circles of radius 6 about x = -10 and 10, 64 sides each.
  std::vector<double> angles;
  for (const int side : {-1, 1})
    for (int i = 0; i <= 64; ++i) {
      const double a = pi * (i / 64.0 - 0.5);
      angles.push_back(std::atan2(6 * std::sin(a), side * (10 + 6 * std::cos(a))));
    }
  const auto opening = [](double a) {
    const double c = std::abs(std::cos(a)), s = std::abs(std::sin(a));
    if (s * 10 >= c * 6) return 6 / s;
    return 10 * c + std::sqrt(36 - 100 * s * s);
  };
  const auto features = features_of_mesh(plate_with_opening(angles, opening, 30, 9));
  const auto slot = the_one(features, "slot");
  CHECK(value_of(slot, "length") == Approx(32).margin(1e-4));
  CHECK(value_of(slot, "width") == Approx(12).margin(1e-4));
  CHECK(value_of(slot, "depth") == Approx(9).margin(1e-4));
  CHECK(slot.faces.size() == 4);
  CHECK(of_kind(features, "fillet").empty());
}

TEST_CASE("simple features: rounds run outside, fillets inside, and chamfers have a width and an angle", "[segment]") {
  const auto round = the_one(features_of_mesh(rounded_block(40, 6, 25)), "round");
  CHECK(value_of(round, "radius") == Approx(6).margin(1e-6));
  CHECK(value_of(round, "length") == Approx(25).margin(0.02));

  // An L with legs of 40 and 10 and a fillet of 5 in its corner.
  std::vector<Vec2> outline = {{0, 0}, {40, 0}, {40, 10}};
  for (int i = 0; i <= 32; ++i) {
    const double a = -pi / 2 - pi / 2 * i / 32;
    outline.emplace_back(15 + 5 * std::cos(a), 15 + 5 * std::sin(a));
  }
  outline.emplace_back(10, 40), outline.emplace_back(0, 40);
  const auto features = features_of_mesh(prism(outline, {5, 5}, 25));
  CHECK(value_of(the_one(features, "fillet"), "radius") == Approx(5).margin(1e-6));
  CHECK(of_kind(features, "round").empty());
  const auto walls = of_kind(features, "wall");
  REQUIRE(walls.size() == 2);  // the legs
  for (const auto& wall : walls) CHECK(value_of(wall, "thickness") == Approx(10).margin(1e-6));

  // A corner cut 3 mm along the longer side, 2 mm along the other.
  const std::vector<Vec2> cut = {{3, 0}, {60, 0}, {60, 40}, {0, 40}, {0, 2}};
  const auto chamfer = the_one(features_of_mesh(prism(cut, {30, 20}, 30)), "chamfer");
  CHECK(value_of(chamfer, "width") == Approx(3).margin(1e-6));
  CHECK(degrees(value_of(chamfer, "angle")) == Approx(degrees(std::atan2(2, 3))).margin(1e-3));
  CHECK(value_of(chamfer, "length") == Approx(30).margin(1e-6));
}

TEST_CASE("simple features: a block is no wall, and what lies across a gap is none", "[segment]") {
  CHECK(of_kind(features_of_mesh(box({0, 0, 0}, {30, 28, 26})), "wall").empty());
  // The sides of a channel, 4 mm thick.
  FacesByHand hand;
  hand.plane({0, 0, 20}, -Vec3::UnitX(), 4000), hand.plane({4, 0, 20}, Vec3::UnitX(), 4000);
  hand.plane({36, 0, 20}, -Vec3::UnitX(), 4000), hand.plane({40, 0, 20}, Vec3::UnitX(), 4000);
  const auto walls = of_kind(simple_features(hand.faces), "wall");
  REQUIRE(walls.size() == 2);
  CHECK(walls[0].faces == std::vector<std::uint32_t>{0, 1});
  CHECK(walls[1].faces == std::vector<std::uint32_t>{2, 3});
  for (const auto& wall : walls) CHECK(value_of(wall, "thickness") == Approx(4));
}

TEST_CASE("simple features: how thick a wall is tells the face whose direction is well known", "[segment]") {
  FacesByHand hand;
  hand.plane({0, 0, 5}, Vec3::UnitZ(), 10000);
  hand.plane({30, 0, 0}, rotation_of({0, 5e-3, 0}) * -Vec3::UnitZ(), 400);  // its direction is off by a sigma
  hand.faces.faces[0].fit.sigma_axis = 1e-5, hand.faces.faces[1].fit.sigma_axis = 5e-3;
  const auto wall = the_one(simple_features(hand.faces), "wall");
  CHECK(value_of(wall, "thickness") == Approx(5).margin(1e-9));
  CHECK(size_of(wall, "thickness").sigma == Approx(0.001 * std::sqrt(2)).epsilon(0.1));
}

TEST_CASE("simple features: equal holes around an axis are a bolt circle, in a line a row", "[segment]") {
  DrilledPlate plate(200, 10);
  plate.drill(0, 0, 20);
  for (int i = 0; i < 6; ++i) plate.drill(60 * std::cos(pi * i / 3), 60 * std::sin(pi * i / 3), 4);
  for (int i = 0; i < 4; ++i) plate.drill(-60 + 25 * i, 80, 2.5);
  const auto features = simple_features(plate.faces);
  CHECK(of_kind(features, "through hole").size() == 11);
  const auto circle = the_one(features, "bolt circle");
  CHECK(value_of(circle, "count") == 6);
  CHECK(value_of(circle, "circle diameter") == Approx(120));
  CHECK(value_of(circle, "hole diameter") == Approx(8));
  CHECK(circle.faces.size() == 6);
  const auto row = the_one(features, "row of holes");
  CHECK(value_of(row, "count") == 4);
  CHECK(value_of(row, "pitch") == Approx(25));
  CHECK(value_of(row, "hole diameter") == Approx(5));
}

TEST_CASE("simple features: a hole that is missing or aside breaks the circle, but not the row on its other side",
          "[segment]") {
  DrilledPlate five(200, 10);
  for (int i = 0; i < 5; ++i) five.drill(60 * std::cos(pi * i / 3), 60 * std::sin(pi * i / 3), 4);  // of six
  CHECK(of_kind(simple_features(five.faces), "bolt circle").empty());
  DrilledPlate bent(200, 10);
  for (int i = 0; i < 5; ++i) bent.drill(20 * i, i == 4 ? 0.5 : 0, 4);
  CHECK(value_of(the_one(simple_features(bent.faces), "row of holes"), "count") == 4);
}

TEST_CASE("simple features: a grid of holes is its rows, the longer ones", "[segment]") {
  DrilledPlate plate(200, 10);
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 4; ++i) plate.drill(20 * i, 20 * j, 3);
  const auto features = simple_features(plate.faces);
  const auto rows = of_kind(features, "row of holes");
  REQUIRE(rows.size() == 3);
  for (const auto& row : rows) CHECK(value_of(row, "count") == 4);
  CHECK(of_kind(features, "bolt circle").empty());
}

TEST_CASE("simple features: sizes carry the uncertainty of the faces that they come from", "[segment]") {
  DrilledPlate plate(200, 10);
  const double sigma = 0.02;
  for (int i = 0; i < 4; ++i) plate.drill(25 * i, 0, 4, sigma);
  for (auto f : {plate.top, plate.bottom}) plate.faces.faces[f].fit.sigma_axis = 0;
  const auto features = simple_features(plate.faces);
  const auto holes = of_kind(features, "through hole");
  REQUIRE(holes.size() == 4);
  CHECK(size_of(holes[0], "diameter").sigma == Approx(2 * sigma));
  CHECK(size_of(holes[0], "depth").sigma == Approx(0.001 * std::sqrt(2)));
  CHECK(size_of(the_one(features, "wall"), "thickness").sigma == Approx(0.001 * std::sqrt(2)));
  const auto row = the_one(features, "row of holes");
  CHECK(size_of(row, "count").sigma == 0);
  CHECK(size_of(row, "pitch").sigma == Approx(sigma / std::sqrt(5)));  // 2 (0.5^2 + 1.5^2)
  CHECK(size_of(row, "hole diameter").sigma == Approx(2 * sigma / 2));
}

TEST_CASE("simple features: turned and moved the part has the same features", "[segment]") {
  const std::vector<Vec2> profile = {{0, 0}, {30, 0}, {30, 40}, {9, 40}, {9, 33}, {4, 33}, {4, 10}, {0, 10}};
  TriangleMesh mesh = turned(profile, 96);
  const auto before = features_of_mesh(mesh);
  const Mat3 rotation = rotation_of({0.3, -0.8, 0.5});
  for (auto& v : mesh.vertices) v = rotation * v + Vec3(100, -50, 20);
  const auto after = features_of_mesh(mesh);
  REQUIRE(before.size() == after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    CHECK(before[i].name == after[i].name);
    CHECK(before[i].kind == after[i].kind);
    REQUIRE(before[i].dimensions.size() == after[i].dimensions.size());
    for (std::size_t k = 0; k < before[i].dimensions.size(); ++k)
      CHECK(before[i].dimensions[k].value == Approx(after[i].dimensions[k].value).margin(1e-6));
  }
}

TEST_CASE("simple features: a bore whose bottom nobody saw is a hole, and says no more", "[segment]") {
  FacesByHand hand;
  const auto top = hand.plane({0, 0, 0}, Vec3::UnitZ(), 4000);
  const auto wall = hand.cylinder({0, 0, -10}, Vec3::UnitZ(), 5, 20, true);
  hand.meet(top, wall, EdgeKind::convex, 10 * pi);
  CHECK(value_of(the_one(simple_features(hand.faces), "hole"), "diameter") == Approx(10));
}

TEST_CASE("simple features: a bore seen from both sides is one hole, though its middle was not seen", "[segment]") {
  const auto bores = [](double radius, double other) {
    DrilledPlate plate(100, 60);
    const auto upper = plate.cylinder({0, 0, 55}, Vec3::UnitZ(), radius, 10, true),
               lower = plate.cylinder({0, 0, 3}, Vec3::UnitZ(), other, 6, true);
    plate.meet(upper, plate.top, EdgeKind::convex, 2 * pi * radius);
    plate.meet(lower, plate.bottom, EdgeKind::convex, 2 * pi * other);
    return plate;
  };
  const auto through = the_one(simple_features(bores(5, 5.001).faces), "through hole");
  CHECK(value_of(through, "depth") == Approx(60));
  CHECK(through.faces.size() == 2);
  // Two that differ may each have a bottom of its own.
  CHECK(of_kind(simple_features(bores(5, 4).faces), "hole").size() == 2);
  // Of a counterbore the shoulder is seen from above, and the bore that it belongs to from below.
  DrilledPlate plate = bores(8, 4);
  const auto shoulder = plate.plane({0, 0, 50}, Vec3::UnitZ(), pi * (64 - 16));
  plate.meet(2, shoulder, EdgeKind::concave, 16 * pi);
  const auto bored = the_one(simple_features(plate.faces), "counterbored hole");
  CHECK(value_of(bored, "diameter") == Approx(8));
  CHECK(value_of(bored, "depth") == Approx(60));
  CHECK(value_of(bored, "counterbore depth") == Approx(10));
}

TEST_CASE("simple features: a bore below a counterbore is part of its hole, if a third of its turn was seen",
          "[segment]") {
  const auto found = [](const Vec3& beside) {
    DrilledPlate plate(100, 20);
    const auto head = plate.cylinder({0, 0, 16}, Vec3::UnitZ(), 7.5, 8, true, 2 * pi);
    const auto shoulder = plate.plane({0, 0, 12}, Vec3::UnitZ(), pi * (7.5 * 7.5 - 4.5 * 4.5));
    const auto bore = plate.cylinder(Vec3(0, 0, 6) + beside, Vec3::UnitZ(), 4.5, 12, true, 0.7 * pi);
    plate.meet(head, plate.top, EdgeKind::convex, 15 * pi), plate.meet(head, shoulder, EdgeKind::concave, 15 * pi);
    plate.meet(bore, shoulder, EdgeKind::convex, 3 * pi), plate.meet(bore, plate.bottom, EdgeKind::convex, 3 * pi);
    return simple_features(plate.faces);
  };
  const auto bored = the_one(found(Vec3::Zero()), "counterbored hole");
  CHECK(value_of(bored, "diameter") == Approx(9));
  CHECK(value_of(bored, "depth") == Approx(20));
  CHECK(value_of(bored, "counterbore depth") == Approx(8));
  CHECK(of_kind(found({2, 0, 0}), "counterbored hole").empty());
}

TEST_CASE("simple features: a wide hole in thin sheet goes through, however long its border is said to be",
          "[segment]") {
  DrilledPlate sheet(200, 1);
  sheet.drill(0, 0, 40);
  for (auto& face : sheet.faces.faces)
    for (auto& n : face.neighbours) n.length *= 2.5;
  CHECK(value_of(the_one(simple_features(sheet.faces), "through hole"), "depth") == Approx(1));
}

TEST_CASE("simple features: faces that share a bore make up a full turn only if they go around it", "[segment]") {
  const auto found = [](bool around) {
    DrilledPlate plate(100, 20);
    const auto first = plate.cylinder({0, 0, 10}, Vec3::UnitZ(), 5, 20, true, 0.9 * pi),
               second = plate.cylinder({0, 0, 10}, Vec3::UnitZ(), 5, 20, true, 0.8 * pi);
    const Vec3 out = plate.faces.faces[first].middle - Vec3(0, 0, 10);
    plate.faces.faces[second].middle = Vec3(0, 0, 10) + (around ? -1 : 1) * out;
    for (const auto f : {first, second})
      plate.meet(f, plate.top, EdgeKind::convex, 14), plate.meet(f, plate.bottom, EdgeKind::convex, 14);
    return of_kind(simple_features(plate.faces), "through hole").size();
  };
  CHECK(found(true) == 1);
  CHECK(found(false) == 0);
}

TEST_CASE("simple features: a hole across a shaft is open at both ends", "[segment]") {
  FacesByHand hand;
  const auto shaft = hand.cylinder({0, 0, 0}, Vec3::UnitX(), 15, 100, false);
  const auto wall = hand.cylinder({0, 0, 0}, Vec3::UnitZ(), 4, 29, true);
  hand.meet(shaft, wall, EdgeKind::convex, 16 * pi);
  CHECK(value_of(the_one(simple_features(hand.faces), "through hole"), "diameter") == Approx(8));
}

}  // namespace partscribe::testing
