/// Claims about the faces of meshes.
#include <algorithm>
#include <catch2/catch.hpp>

#include "core/number.h"
#include "geometry/segment/faces.h"
#include "testing/meshes.h"

namespace partscribe::testing {
namespace {

Faces faces_of(const TriangleMesh& mesh, double tolerance = 0.02) {
  FaceOptions options;
  options.tolerance = tolerance;
  Context context;
  return faces_of_mesh(mesh, options, context);
}

int count(const Faces& faces, FaceKind kind) {
  return static_cast<int>(
      std::count_if(faces.faces.begin(), faces.faces.end(), [&](const Face& f) { return f.kind == kind; }));
}

const Face& the(const Faces& faces, FaceKind kind) {
  REQUIRE(count(faces, kind) == 1);
  return *std::find_if(faces.faces.begin(), faces.faces.end(), [&](const Face& f) { return f.kind == kind; });
}

EdgeKind edge_between(const Faces& faces, const Face& a, FaceKind other) {
  for (const auto& n : a.neighbours)
    if (faces.faces[n.face].kind == other) return n.edge;
  FAIL("no such neighbour");
  return EdgeKind::convex;
}

TEST_CASE("mesh faces: a plate with a hole has six planes and one cylinder, exact to the corners of its polygon") {
  for (const int sectors : {8, 32, 128}) {
    const Faces faces = faces_of(holed_plate(40, 10, 6, 0, 0, sectors));
    CHECK(faces.of_mesh);
    CHECK(faces.faces.size() == 7);
    CHECK(count(faces, FaceKind::plane) == 6);
    const Face& hole = the(faces, FaceKind::cylinder);
    CHECK(hole.hollow);
    CHECK(hole.surface().radius == Approx(6).epsilon(1e-6));
    CHECK(hole.surface().point.head<2>().norm() < 1e-6);
    CHECK(hole.arc == Approx(2 * pi));
    CHECK(hole.high - hole.low == Approx(10));
    CHECK(hole.coverage > 0.97);
    CHECK(hole.neighbours.size() == 2);
    CHECK(edge_between(faces, hole, FaceKind::plane) == EdgeKind::convex);
    CHECK(hole.sagitta == Approx(6 * (1 - std::cos(pi / sectors))).epsilon(1e-3));
    for (const auto f : faces.face_of) CHECK(f < 7);
  }
}

TEST_CASE("mesh faces: a rounded edge runs smoothly into its planes, and is no hole") {
  const Faces faces = faces_of(rounded_block(30, 4, 12));
  const Face& round = the(faces, FaceKind::cylinder);
  CHECK_FALSE(round.hollow);
  CHECK(round.surface().radius == Approx(4).epsilon(1e-5));
  CHECK(round.arc == Approx(pi / 2).margin(0.02));
  int smooth = 0, sharp = 0;
  for (const auto& n : round.neighbours) (n.edge == EdgeKind::tangent ? smooth : sharp)++;
  CHECK(smooth == 2);
  CHECK(sharp == 2);
}

TEST_CASE("mesh faces: a turned part has a cylinder, a cone and flat ends") {
  const Faces faces = faces_of(turned({{0, 0}, {8, 0}, {8, 12}, {4, 20}, {0, 20}}, 40));
  CHECK(faces.faces.size() == 4);
  const Face& cone = the(faces, FaceKind::cone);
  CHECK(cone.surface().half_angle == Approx(std::atan(0.5)).epsilon(1e-6));
  CHECK(cone.surface().radius == Approx(6).epsilon(1e-6));  // half way between its ends
  CHECK(edge_between(faces, cone, FaceKind::cylinder) == EdgeKind::convex);
}

TEST_CASE("mesh faces: a cone of rings that are turned against each other is one cone") {
  // As meshers write it: each triangle bridges the angle of two corners of the ring beside it.
  const std::vector<Vec2> profile = {{8, 0}, {8, 10}, {7, 11}, {6, 12}, {5, 13}};
  const std::uint32_t sectors = 18, rings = static_cast<std::uint32_t>(profile.size());
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < rings; ++i)
    for (std::uint32_t j = 0; j < sectors; ++j) {
      const double a = 2 * pi * (j + (i < 2 ? 0 : 0.5 * (i - 1))) / sectors;
      mesh.vertices.emplace_back(profile[i].x() * std::cos(a), profile[i].x() * std::sin(a), profile[i].y());
    }
  mesh.vertices.emplace_back(0, 0, 0), mesh.vertices.emplace_back(0, 0, 13);
  for (std::uint32_t j = 0; j < sectors; ++j) {
    const std::uint32_t k = (j + 1) % sectors, top = (rings - 1) * sectors;
    for (std::uint32_t i = 0; i + 1 < rings; ++i) {
      const std::uint32_t low = i * sectors, high = low + sectors;
      mesh.triangles.push_back({low + j, low + k, i == 0 ? high + k : high + j});
      mesh.triangles.push_back({i == 0 ? low + j : low + k, high + k, high + j});
    }
    mesh.triangles.push_back({rings * sectors, k, j}),
        mesh.triangles.push_back({rings * sectors + 1, top + j, top + k});
  }
  const Faces faces = faces_of(mesh);
  CHECK(faces.faces.size() == 4);
  const Face& cone = the(faces, FaceKind::cone);
  CHECK(degrees(cone.surface().half_angle) == Approx(45).margin(1e-6));
  CHECK(cone.low == Approx(-1.5).margin(1e-6));
}

TEST_CASE("mesh faces: where they run out is said") {
  TriangleMesh mesh = holed_plate(40, 10, 6, 5, -8, 32);
  for (const auto& face : faces_of(mesh).faces) CHECK(face.complete);
  mesh.triangles.pop_back();
  const Faces open = faces_of(mesh);
  CHECK(std::any_of(open.faces.begin(), open.faces.end(), [](const Face& f) { return !f.complete; }));
}

TEST_CASE("mesh faces: the order of the triangles changes nothing but their numbers") {
  TriangleMesh mesh = holed_plate(40, 10, 6, 5, -8, 32);
  const Faces before = faces_of(mesh);
  std::reverse(mesh.triangles.begin(), mesh.triangles.end());
  const Faces after = faces_of(mesh);
  REQUIRE(before.faces.size() == after.faces.size());
  for (std::size_t t = 0; t < before.face_of.size(); ++t) {
    const Face& a = before.faces[before.face_of[t]];
    const Face& b = after.faces[after.face_of[after.face_of.size() - 1 - t]];
    CHECK(a.kind == b.kind);
    CHECK(a.area == Approx(b.area));
  }
}

}  // namespace
}  // namespace partscribe::testing
