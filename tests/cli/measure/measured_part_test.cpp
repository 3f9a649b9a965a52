/// What is worked out from faces and the data behind them.
#include "cli/measure/measured_part.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "core/number.h"
#include "core/random.h"
#include "testing/measured.h"
#include "testing/meshes.h"

namespace partscribe::testing {

namespace {

/// One face, of the given triangles; all others belong to none.
Faces one_plane(const TriangleMesh& mesh, const std::vector<std::uint32_t>& members) {
  Faces faces;
  faces.of_mesh = true;
  faces.face_of.assign(mesh.triangles.size(), no_face);
  Face face = plane_face(mesh.corner(members.front(), 0), triangle_normal(mesh, members.front()), 1);
  face.members = members;
  for (const auto t : members) faces.face_of[t] = 0;
  faces.faces = {face};
  return faces;
}

}  // namespace

TEST_CASE("measured part: a plane has the size of the rectangle around it, however it lies") {
  for (const auto& turn : {Vec3(0, 0, 0), Vec3(0.3, -0.2, 1.1)}) {
    Scan scan;
    scan.mesh = transformed(box({0, 0, 0}, {80, 60, 10}), {rotation_of(turn), {5, 6, 7}});
    const auto sizes = sizes_of_planes(scan, one_plane(scan.mesh, {2, 3}));  // z = 10
    REQUIRE(sizes.size() == 1);
    CHECK(sizes[0].x() == Approx(80));
    CHECK(sizes[0].y() == Approx(60));
  }
}

TEST_CASE("measured part: the size of a plane in a cloud is that of its points") {
  Scan scan;
  Random random(5);
  Faces faces;
  Face face = plane_face({0, 0, 0}, Vec3(1, 1, 1).normalized(), 600);
  const Mat3 frame = rotation_onto_axis(face.surface().axis);
  for (std::uint32_t i = 0; i < 20'000; ++i) {
    scan.cloud.points.push_back(frame * Vec3(random.uniform(-20, 20), random.uniform(-7.5, 7.5), 0));
    face.members.push_back(i);
  }
  faces.faces = {face};
  faces.face_of.assign(scan.cloud.size(), 0);
  const auto sizes = sizes_of_planes(scan, faces);
  CHECK(sizes[0].x() == Approx(40).margin(0.1));
  CHECK(sizes[0].y() == Approx(15).margin(0.1));
}

TEST_CASE("measured part: triangles without a face are told as connected places, with their area") {
  Scan scan;
  scan.mesh = joined(box({0, 0, 0}, {80, 60, 10}), box({100, 0, 0}, {101, 1, 1}));
  const auto places = unclassified_places(scan, one_plane(scan.mesh, {2, 3}), 0.1);
  REQUIRE(places.size() == 2);
  CHECK(places[0].area == Approx(80 * 60 + 2 * 80 * 10 + 2 * 60 * 10));
  CHECK(places[0].reason.find("no plane") == 0);
  CHECK(places[1].area == Approx(6));
  CHECK((places[1].place - Vec3(100.5, 0.5, 0.5)).norm() < 1);
  CHECK(unclassified_places(scan, one_plane(scan.mesh, {2, 3}), 0.8)[1].reason.find("too small") == 0);
}

TEST_CASE("measured part: points without a face are told as places, and rejected ones are none") {
  Scan scan;
  Faces faces;
  Face face = plane_face({0, 0, 0}, {0, 0, 1}, 100);
  auto add = [&](const Vec3& p, std::uint32_t of, bool rejected) {
    if (of == 0) face.members.push_back(static_cast<std::uint32_t>(scan.cloud.size()));
    scan.cloud.points.push_back(p);
    scan.cloud.rejected.push_back(rejected);
    faces.face_of.push_back(of);
  };
  for (int x = 0; x < 100; ++x)
    for (int y = 0; y < 100; ++y) add({0.1 * x, 0.1 * y, 0}, 0, false);
  for (int x = 0; x < 20; ++x)
    for (int y = 0; y < 20; ++y) add({0.1 * x, 0.1 * y, 5 + 0.002 * x * y}, no_face, false);
  for (int i = 0; i < 50; ++i) add({0.5 * i, 3, 9}, no_face, true);
  faces.faces = {face};
  const auto places = unclassified_places(scan, faces, 0.02);
  REQUIRE(places.size() == 1);
  CHECK(places[0].area == Approx(4));
  CHECK(places[0].place.z() == Approx(5.2).margin(0.3));
}

TEST_CASE("measured part: faces are listed by kind under the numbers they have everywhere") {
  const Faces faces = measured_plate().faces;
  CHECK(face_name(faces, 0) == "plane 1");
  CHECK(face_name(faces, 5) == "free form 6");
  CHECK(face_list(faces, {3, 1, 0, 5, 2}) == "planes 1, 2; cylinders 3, 4; free form 6");
  CHECK(face_list(faces, {0, 1, 2, 3}, 1) == "planes 1 and 1 more; cylinders 3 and 1 more");
}

}  // namespace partscribe::testing
