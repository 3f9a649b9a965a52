/// Claims about the faces of scanned points.
#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>

#include "core/number.h"
#include "core/random.h"
#include "geometry/normals/normals.h"
#include "geometry/segment/faces.h"
#include "testing/meshes.h"

namespace partscribe::testing {
namespace {

/// Random places by area, with noise along the normal; no rays, no normals.
Scan scattered(const TriangleMesh& mesh, std::size_t count, double sigma, std::uint64_t seed) {
  std::vector<double> up_to = {0};
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 0);
    up_to.push_back(up_to.back() + (mesh.corner(t, 1) - a).cross(mesh.corner(t, 2) - a).norm());
  }
  Random random(seed);
  Scan scan;
  while (scan.cloud.points.size() < count) {
    const auto above = std::upper_bound(up_to.begin() + 1, up_to.end() - 1, random.uniform() * up_to.back());
    const auto t = static_cast<std::size_t>(above - up_to.begin()) - 1;
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3 a = mesh.corner(t, 0);
    scan.cloud.points.push_back(a + u * (mesh.corner(t, 1) - a) + v * (mesh.corner(t, 2) - a) +
                                sigma * random.normal() * triangle_normal(mesh, t));
  }
  scan.views.push_back({});
  return scan;
}

Scan prepared(const TriangleMesh& mesh, std::size_t points, double sigma, std::uint64_t seed = 1) {
  Scan scan = scattered(mesh, points, sigma, seed);
  Context context;
  estimate_normals(scan.cloud, {}, context);
  return scan;
}

Faces faces_of(const PointCloud& cloud, int threads = 1) {
  Context context;
  context.threads = threads;
  return faces_of_cloud(cloud, {}, context);
}

std::vector<Face> of_kind(const Faces& faces, FaceKind kind) {
  std::vector<Face> found;
  for (const auto& f : faces.faces)
    if (f.kind == kind) found.push_back(f);
  return found;
}

TEST_CASE("cloud faces: a plate with a hole has six planes and one cylinder within their sigmas") {
  const Scan scan = prepared(holed_plate(40, 10, 6, 5, -8), 40000, 0.03);
  const Faces faces = faces_of(scan.cloud);
  CHECK_FALSE(faces.of_mesh);
  CHECK(of_kind(faces, FaceKind::plane).size() == 6);
  const auto holes = of_kind(faces, FaceKind::cylinder);
  REQUIRE(holes.size() == 1);
  const Face& hole = holes.front();
  CHECK(hole.hollow);
  CHECK(std::abs(hole.surface().radius - 6) < 4 * hole.fit.sigma_radius + 0.002);  // 128 sides stand 0.001 mm in
  CHECK(hole.fit.sigma_radius < 0.01);
  CHECK((hole.surface().point.head<2>() - Vec2(5, -8)).norm() < 5 * hole.fit.sigma_point);
  CHECK(hole.arc == Approx(2 * pi).margin(0.1));
  CHECK(hole.high - hole.low == Approx(10).margin(0.5));
  for (const auto& plane : of_kind(faces, FaceKind::plane)) {
    const double outward = plane.surface().axis.dot(plane.middle - Vec3(0, 0, 5));
    CHECK(outward > 0);
  }
  const auto labelled = std::count_if(faces.face_of.begin(), faces.face_of.end(), [](auto f) { return f != no_face; });
  CHECK(static_cast<double>(labelled) > 0.98 * static_cast<double>(faces.face_of.size()));
}

TEST_CASE("cloud faces: a cone between a cylinder and a plane is one cone") {
  const Scan scan = prepared(turned({{0, 0}, {8, 0}, {8, 12}, {4, 20}, {0, 20}}, 200), 30000, 0.02);
  const Faces faces = faces_of(scan.cloud);
  CHECK(of_kind(faces, FaceKind::plane).size() == 2);
  CHECK(of_kind(faces, FaceKind::cylinder).size() == 1);
  const auto cones = of_kind(faces, FaceKind::cone);
  REQUIRE(cones.size() == 1);
  CHECK(cones[0].surface().half_angle == Approx(std::atan(0.5)).margin(0.003));
  CHECK_FALSE(cones[0].hollow);
}

TEST_CASE("cloud faces: a cone that a cylinder follows within the noise is a cone, and a cylinder stays one") {
  for (const double taper : {0.05, 0.0}) {  // mm over the height: about a sigma at either end
    const Scan scan = prepared(turned({{0, 0}, {8, 0}, {8 + taper, 20}, {0, 20}}, 400), 30000, 0.02);
    const Faces faces = faces_of(scan.cloud);
    CHECK(faces.faces.size() == 3);
    CHECK(of_kind(faces, FaceKind::plane).size() == 2);
    CHECK(of_kind(faces, FaceKind::cylinder).size() == (taper > 0 ? 0 : 1));
    const auto cones = of_kind(faces, FaceKind::cone);
    REQUIRE(cones.size() == (taper > 0 ? 1 : 0));
    for (const auto& cone : cones) CHECK(cone.surface().half_angle == Approx(taper / 20).margin(0.001));
  }
}

TEST_CASE("cloud faces: a small hole keeps its points beside large faces") {
  const Scan scan = prepared(holed_plate(60, 8, 1.5, 10, 10), 120000, 0.02);
  const auto holes = of_kind(faces_of(scan.cloud), FaceKind::cylinder);
  REQUIRE(holes.size() == 1);
  CHECK(holes[0].surface().radius == Approx(1.5).margin(0.02));
}

TEST_CASE("cloud faces: the number of threads changes nothing") {
  const Scan scan = prepared(holed_plate(40, 10, 6, 5, -8), 15000, 0.03);
  const Faces one = faces_of(scan.cloud, 1), three = faces_of(scan.cloud, 3);
  CHECK(one.face_of == three.face_of);
  REQUIRE(one.faces.size() == three.faces.size());
  for (std::size_t f = 0; f < one.faces.size(); ++f)
    CHECK(one.faces[f].surface().point == three.faces[f].surface().point);
}

TEST_CASE("cloud faces: points without a surface have no face") {
  Scan scan;
  Random random(7);
  for (int i = 0; i < 3000; ++i)
    scan.cloud.points.emplace_back(random.uniform(0, 10), random.uniform(0, 10), random.uniform(0, 10));
  Context context;
  estimate_normals(scan.cloud, {}, context);
  std::size_t labelled = 0;
  for (const auto f : faces_of(scan.cloud).face_of) labelled += f != no_face;
  CHECK(labelled < 600);
}

}  // namespace
}  // namespace partscribe::testing
