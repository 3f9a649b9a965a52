/// Claims about what holds between faces: accepted within their uncertainty, refused where it is meant otherwise.
#include "fit/relations/relations.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"
#include "testing/faces.h"
#include "testing/meshes.h"

namespace partscribe::testing {
namespace {

using fit::FaceRelation;
using fit::RelationKind;

std::vector<FaceRelation> of_kind(const std::vector<FaceRelation>& relations, RelationKind kind) {
  std::vector<FaceRelation> found;
  std::copy_if(relations.begin(), relations.end(), std::back_inserter(found),
               [&](const FaceRelation& r) { return r.kind == kind; });
  return found;
}

FaceRelation the_one(const Faces& faces, RelationKind kind, double tolerance) {
  const auto found = of_kind(fit::relations_between(faces, tolerance), kind);
  REQUIRE(found.size() == 1);
  return found.front();
}

Vec3 tilted(const Vec3& direction, const Vec3& about, double angle) { return rotation_of(angle * about) * direction; }

/// A square plane of 60 mm through the origin, and another 20 mm above that leans by `angle`.
Faces two_planes(double angle, double sigma_axis) {
  FacesByHand hand;
  hand.plane({0, 0, 20}, Vec3::UnitZ(), 3600);
  hand.plane({0, 0, 0}, tilted(-Vec3::UnitZ(), Vec3::UnitX(), angle), 3500);
  for (auto& face : hand.faces.faces) face.fit.sigma_axis = sigma_axis;
  return hand.faces;
}

}  // namespace

TEST_CASE("relations: planes are parallel within their sigmas, and only as far as they need not move much",
          "[relations]") {
  const auto close = the_one(two_planes(2e-4, 1e-4), RelationKind::parallel, 0.2);
  CHECK(close.value == Approx(2e-4));
  CHECK(close.sigma == Approx(1e-4 * std::sqrt(2)).epsilon(0.1));
  CHECK(close.z == Approx(close.value / close.sigma));
  CHECK(close.accepted);
  CHECK_FALSE(the_one(two_planes(1e-3, 1e-4), RelationKind::parallel, 0.2).accepted);  // seven sigmas
  // Within the sigmas, but one end would move by half of 42 mm times 0.01: more than a quarter of the tolerance.
  CHECK_FALSE(the_one(two_planes(0.01, 0.01), RelationKind::parallel, 0.2).accepted);
  CHECK(the_one(two_planes(0.01, 0.01), RelationKind::parallel, 2).accepted);
  CHECK(fit::relations_between(two_planes(0.1, 1e-4), 0.2).empty());  // nobody takes that for parallel
}

TEST_CASE("relations: what is exact is tested against the tolerance", "[relations]") {
  // A draft of half a degree on an exact mesh is meant; rounding to floats is not.
  CHECK_FALSE(the_one(two_planes(radians(0.5), 0), RelationKind::parallel, 0.1).accepted);
  CHECK(the_one(two_planes(1e-6, 0), RelationKind::parallel, 0.1).accepted);
}

TEST_CASE("relations: each face stands beside the largest of its direction, not beside all", "[relations]") {
  FacesByHand hand;
  for (int i = 0; i < 20; ++i) hand.plane({0, 0, 10.0 * i}, Vec3::UnitZ(), 4000 - i);
  for (int i = 0; i < 20; ++i) hand.plane({100.0 + 10 * i, 0, 0}, Vec3::UnitX(), 3000 - i);
  hand.cylinder({500, 0, 0}, Vec3::UnitZ(), 5, 40, true);
  const auto relations = fit::relations_between(hand.faces, 0.1);
  const auto parallel = of_kind(relations, RelationKind::parallel);
  CHECK(parallel.size() == 19 + 19 + 1);
  for (const auto& r : parallel) CHECK((r.first == 0 || r.first == 20));
  const auto orthogonal = of_kind(relations, RelationKind::orthogonal);
  REQUIRE(orthogonal.size() == 1);
  CHECK(orthogonal[0].first == 0);
  CHECK(orthogonal[0].second == 20);
  CHECK(orthogonal[0].accepted);
}

TEST_CASE("relations: bores are coaxial where neither place nor direction speaks against it", "[relations]") {
  const auto bores = [](double aside, double lean, double sigma) {
    FacesByHand hand;
    hand.cylinder({0, 0, 0}, Vec3::UnitZ(), 10, 40, true, 2 * pi, sigma);
    hand.cylinder({aside, 0, 60}, tilted(Vec3::UnitZ(), Vec3::UnitY(), lean), 6, 30, true, 2 * pi, sigma);
    for (auto& face : hand.faces.faces) face.fit.sigma_axis = sigma / 20;
    return the_one(hand.faces, RelationKind::coaxial, 0.2);
  };
  const auto near_enough = bores(0.01, 0, 0.005);
  CHECK(near_enough.accepted);
  CHECK(near_enough.value == Approx(0.01));
  // Errors of the direction count with the 60 mm between them.
  CHECK(near_enough.sigma == Approx(std::sqrt(2 + 9) * 0.005).epsilon(0.05));
  CHECK_FALSE(bores(0.08, 0, 0.005).accepted);
  CHECK_FALSE(bores(0.0, 0.002, 0.005).accepted);
}

TEST_CASE("relations: planes in one plane, radii that are one, and those that are not", "[relations]") {
  const auto steps = [](double up) {
    FacesByHand hand;
    hand.plane({0, 0, 0}, Vec3::UnitZ(), 900, 0.002);
    hand.plane({80, 0, up}, Vec3::UnitZ(), 800, 0.002);
    for (auto& face : hand.faces.faces) face.fit.sigma_axis = 1e-5;
    return the_one(hand.faces, RelationKind::coplanar, 0.1);
  };
  CHECK(steps(0.004).accepted);
  CHECK(steps(0.004).value == Approx(0.004));
  CHECK_FALSE(steps(0.02).accepted);

  FacesByHand hand;
  hand.cylinder({0, 0, 0}, Vec3::UnitZ(), 5, 20, true, 2 * pi, 0.003);
  hand.cylinder({30, 0, 0}, Vec3::UnitZ(), 5.005, 18, true, 2 * pi, 0.003);
  hand.cylinder({60, 0, 0}, Vec3::UnitZ(), 5.1, 16, true, 2 * pi, 0.003);
  hand.cylinder({90, 0, 0}, Vec3::UnitZ(), 8, 10, true, 2 * pi, 0.003);
  const auto equal = of_kind(fit::relations_between(hand.faces, 0.1), RelationKind::equal_radius);
  REQUIRE(equal.size() == 2);  // 8 is not near
  CHECK(equal[0].accepted);
  CHECK(equal[0].value == Approx(0.005));
  CHECK_FALSE(equal[1].accepted);
  CHECK(equal[1].second == 2);
}

TEST_CASE("relations: rounds are tangent to what they join", "[relations]") {
  for (const double off : {0.0, 0.05}) {
    FacesByHand hand;
    const auto floor = hand.plane({0, 0, 0}, Vec3::UnitZ(), 4000);
    const auto fillet = hand.cylinder({0, 0, 4 + off}, Vec3::UnitX(), 4, 50, true, pi / 2);
    const auto ball = hand.sphere({25, 0, 4 + off}, 4, true, 20);
    const auto wall = hand.plane({0, 30, 0}, Vec3::UnitY(), 2000);  // sharp beside the floor
    hand.meet(floor, fillet, EdgeKind::tangent, 50), hand.meet(fillet, ball, EdgeKind::tangent, 6);
    hand.meet(floor, ball, EdgeKind::tangent, 1), hand.meet(floor, wall, EdgeKind::convex, 50);
    const auto tangent = of_kind(fit::relations_between(hand.faces, 0.1), RelationKind::tangent);
    REQUIRE(tangent.size() == 3);
    for (const auto& r : tangent) {
      const bool joins_floor = r.first == floor;
      CHECK(r.value == Approx(joins_floor ? off : 0).margin(1e-9));
      CHECK(r.accepted == (!joins_floor || off == 0));
    }
  }
}

TEST_CASE("relations: one in a hundred true relations is refused, whatever the noise", "[relations]") {
  Random random(11);
  int refused_directions = 0, refused_radii = 0;
  const int runs = 4000;
  for (int run = 0; run < runs; ++run) {
    const double sigma = 2e-3, turn = 1e-4;
    FacesByHand hand;
    for (int k = 0; k < 2; ++k) {
      const Vec3 axis(turn * random.normal(), turn * random.normal(), 1);
      hand.cylinder({100.0 * k, 0, 0}, axis, 5 + sigma * random.normal(), 40 - k, true, 2 * pi, sigma);
      hand.faces.faces.back().fit.sigma_axis = turn;
    }
    const auto relations = fit::relations_between(hand.faces, 0.1);
    for (const auto& r : relations) {
      refused_directions += r.kind == RelationKind::parallel && !r.accepted;
      refused_radii += r.kind == RelationKind::equal_radius && !r.accepted;
    }
  }
  CHECK(refused_directions / double(runs) == Approx(0.01).margin(0.005));
  CHECK(refused_radii / double(runs) == Approx(0.01).margin(0.005));
}

TEST_CASE("relations: of a turned part all faces share the axis, and its ends stand across it", "[relations]") {
  const std::vector<Vec2> profile = {{0, 0}, {30, 0}, {30, 40}, {9, 40}, {9, 33}, {4, 33}, {4, 10}, {0, 10}};
  TriangleMesh mesh = turned(profile, 96);
  const Mat3 rotation = rotation_of({0.3, -0.8, 0.5});
  for (auto& v : mesh.vertices) v = rotation * v + Vec3(100, -50, 20);
  Context context;
  const Faces faces = faces_of_mesh(mesh, {}, context);
  const auto relations = fit::relations_between(faces, 0.05);
  CHECK(of_kind(relations, RelationKind::coaxial).size() == 2);   // two bores beside the outside
  CHECK(of_kind(relations, RelationKind::parallel).size() == 6);  // all others beside one of the seven
  CHECK(of_kind(relations, RelationKind::coplanar).empty());
  for (const auto& r : relations) CHECK(r.accepted);
}

}  // namespace partscribe::testing
