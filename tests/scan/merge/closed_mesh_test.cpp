/// A closed mesh drawn onto points of known surfaces: tight, within tolerance both ways, fine only where it has to be.
#include "scan/merge/closed_mesh.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "geometry/mesh/mesh_distance.h"
#include "testing/free_forms.h"
#include "testing/registration/cases.h"

using namespace partscribe::scan;
using namespace partscribe::testing;

namespace {

ClosedMesh closed_around(const std::vector<Vec3>& points, const ClosedMeshOptions& options, int threads = 2) {
  Context context;
  context.threads = threads;
  const auto found = closed_mesh_around(points, options, context);
  REQUIRE(found);
  return *found;
}

bool watertight(const ClosedMesh& found) {
  const MeshTopology t = topology(found.mesh);
  return t.closed() && t.components == 1 && volume(found.mesh) > 0 && found.crossings == 0;
}

/// mm; how far corners and middles of triangles are from a true surface at most.
double farthest_from(const TriangleMesh& mesh, const TriangleMesh& truth) {
  const MeshDistance distance(truth);
  double worst = 0;
  for (const Vec3& v : mesh.vertices) worst = std::max(worst, distance.closest(v).distance);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    worst = std::max(worst, distance.closest((mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3).distance);
  return worst;
}

/// A ball of radius 20 with a small hill on its top.
std::vector<Vec3> hilly_ball(int count) {
  Random random(3);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const Vec3 n = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    points.push_back((20 + 4 * std::exp(-40 * (1 - n.z()))) * n);
  }
  return points;
}

double longest_edge_at(const TriangleMesh& mesh, std::size_t t) {
  double longest = 0;
  for (int k = 0; k < 3; ++k) longest = std::max(longest, (mesh.corner(t, k) - mesh.corner(t, (k + 1) % 3)).norm());
  return longest;
}

}  // namespace

TEST_CASE("closed mesh: views of a sculpture, registered, become one tight surface within the tolerance of its own") {
  const TriangleMesh truth = sculpture(120);
  SimulateOptions scanner = registration::small();
  scanner.resolution = 100, scanner.views = "octahedron", scanner.bit_error = 0;
  const registration::Case scan = registration::scan_of(surface_of(truth), scanner, radians(2), 1);
  const Registration registered = registration::run(scan.views);
  const Pose truth_from_world = scan.truth[0] * registered.views[0].world_from_view.inverse();
  std::vector<Vec3> points;
  for (std::size_t v = 0; v < scan.views.size(); ++v) {
    REQUIRE(registered.views[v].status != ViewStatus::refused);
    for (const Vec3& p : scan.views[v].cloud.points)
      points.push_back(truth_from_world * registered.views[v].world_from_view * p);
  }
  const ClosedMesh found = closed_around(points, {.tolerance = 0.2});
  INFO("worst " << found.worst << ", rms " << found.rms << ", triangles " << found.mesh.triangles.size());
  CHECK(watertight(found));
  CHECK(found.start_count == 320);
  CHECK(found.within == 1);
  CHECK(found.worst <= 0.2);
  CHECK(found.rms < 0.06);
  CHECK(farthest_from(found.mesh, truth) < 0.4);
  CHECK(volume(found.mesh) == Approx(volume(truth)).epsilon(0.005));
  CHECK(found.mesh.triangles.size() < points.size() / 2);
}

TEST_CASE("closed mesh: the tolerance is kept, and a finer one costs more triangles") {
  const TriangleMesh truth = pebble(100);
  std::size_t last = 0;
  for (const double tolerance : {1.0, 0.2, 0.05}) {
    const ClosedMesh found = closed_around(truth.vertices, {.tolerance = tolerance});
    INFO("tolerance " << tolerance << ": worst " << found.worst << ", triangles " << found.mesh.triangles.size());
    CHECK(watertight(found));
    CHECK(found.worst <= tolerance);
    CHECK(farthest_from(found.mesh, truth) < 2 * tolerance);
    CHECK(found.mesh.triangles.size() > last);
    last = found.mesh.triangles.size();
  }
}

TEST_CASE("closed mesh: triangles are small where the surface asks for it, and stay large elsewhere") {
  const ClosedMesh found = closed_around(hilly_ball(20000), {.tolerance = 0.15});
  CHECK(watertight(found));
  CHECK(found.worst <= 0.15);
  double on_hill = 0, beside = 0;
  int hill_count = 0, beside_count = 0;
  for (std::size_t t = 0; t < found.mesh.triangles.size(); ++t) {
    const bool hill = found.mesh.corner(t, 0).normalized().z() > 0.97;
    (hill ? on_hill : beside) += longest_edge_at(found.mesh, t), ++(hill ? hill_count : beside_count);
  }
  CHECK(on_hill / hill_count < 0.7 * beside / beside_count);
}

TEST_CASE("closed mesh: where nobody looked it spans straight on, and is tight all the same") {
  auto points = hilly_ball(20000);
  std::erase_if(points, [](const Vec3& p) { return p.z() < -14; });
  const ClosedMesh found = closed_around(points, {.tolerance = 0.15});
  CHECK(watertight(found));
  CHECK(found.worst <= 0.15);
  for (const Vec3& v : found.mesh.vertices) CHECK(v.z() > -21);
}

TEST_CASE("closed mesh: the hole of a ring is beyond it, and it says so") {
  const ClosedMesh found = closed_around(wavy_ring(120).vertices, {.tolerance = 0.2, .most_triangles = 6000});
  CHECK(topology(found.mesh).closed());
  CHECK((found.within < 1 || found.crossings > 0));
}

TEST_CASE("closed mesh: the same for any number of threads, bad_points say what was expected") {
  const auto points = hilly_ball(3000);
  const ClosedMesh one = closed_around(points, {}, 1), three = closed_around(points, {}, 3);
  CHECK(one.mesh.vertices == three.mesh.vertices);
  CHECK(one.mesh.triangles == three.mesh.triangles);
  Context context;
  CHECK(closed_mesh_around({points.begin(), points.begin() + 7}, {}, context).error().message ==
        "expected at least 20 points all around a body, found 7");
  auto flat = points;
  for (Vec3& p : flat) p.z() = 1;
  CHECK(closed_mesh_around(flat, {}, context).error().message ==
        "expected points all around a body, found 3000 in a plane");
}
