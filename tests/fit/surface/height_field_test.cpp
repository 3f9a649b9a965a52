#include "fit/surface/height_field.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/mesh/self_intersection.h"

using namespace partscribe::fit;

namespace {

double wave(double x, double y) { return 2 * std::sin(0.3 * x) * std::cos(0.2 * y); }

/// A pinhole's picture, from the origin along +z, of a wavy ground at depth 300 and a plateau 20 mm nearer.
PointCloud two_levels(double sigma, std::uint64_t seed, bool hole = false) {
  Random random(seed);
  PointCloud cloud;
  for (int row = -60; row <= 60; ++row)
    for (int column = -80; column <= 80; ++column) {
      const Vec3 ray(column * 0.4 / 300, row * 0.4 / 300, 1);
      const bool near = column > 10 && column < 50 && std::abs(row) < 25;
      if (hole && Vec2(column + 40, row).norm() < 15) continue;
      const double depth = near ? 280 : 300;
      Vec3 p = depth * ray;
      // The ground's height over the ray, in a few steps of a fixed point iteration.
      for (int k = 0; k < 8 && !near; ++k) p = (depth + wave(p.x(), p.y())) * ray;
      cloud.points.push_back(p + sigma * random.normal() * ray.normalized());
    }
  return cloud;
}

std::optional<HeightField> field_of(PointCloud& cloud, double max_error, Context& context,
                                    const std::vector<View>& views = {}) {
  const SamplingSummary sampling = estimate_normals(cloud, {}, context);
  HeightFieldOptions options;
  options.max_error = max_error;
  options.oriented = !cloud.rays.empty();
  return triangulated_height_field(cloud, views, sampling, options, context);
}

double true_distance(const Vec3& p) {
  return std::min(std::abs(p.z() - 280), std::abs(p.z() - 300 - wave(p.x(), p.y())));
}

}  // namespace

TEST_CASE("height field: a step of depth leaves two pieces, both facing the sensor and near the truth") {
  Context context;
  PointCloud cloud = two_levels(0.02, 3);
  const auto field = field_of(cloud, 0.1, context);
  REQUIRE(field);
  const TriangleMesh& mesh = field->mesh;
  const MeshTopology top = topology(mesh);
  CHECK(top.components == 2);
  CHECK(top.nonmanifold_edges == 0);
  CHECK(top.inconsistent_edges == 0);
  CHECK(self_intersections(mesh).empty());
  CHECK(field->towards_sensor.z() < -0.99);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
    REQUIRE(triangle_normal(mesh, t).dot(middle) < 0);
    REQUIRE(true_distance(middle) < 0.16);
  }
  // No triangle spans the step, and every point but the outliers finds its surface.
  const MeshDistance distance(mesh);
  std::size_t off = 0;
  for (const Vec3& p : cloud.points) off += distance.closest(p).distance > 0.2;
  CHECK(off < cloud.size() / 1000);
  CHECK(mesh.triangles.size() < cloud.size() / 8);
}

TEST_CASE("height field: a smaller bound is kept with more triangles") {
  Context context;
  std::size_t triangles = 0;
  for (const double bound : {0.4, 0.1, 0.03}) {
    PointCloud cloud = two_levels(0, 3);
    const auto field = field_of(cloud, bound, context);
    REQUIRE(field);
    const MeshDistance distance(field->mesh);
    double worst = 0;
    for (const Vec3& p : cloud.points)
      if (std::abs(p.z() - 280) > 1) worst = std::max(worst, distance.closest(p).distance);
    INFO("bound " << bound);
    CHECK(worst < 1.5 * bound + 0.02);
    CHECK(field->mesh.triangles.size() > triangles);
    triangles = field->mesh.triangles.size();
  }
}

TEST_CASE("height field: missing data stay a hole") {
  Context context;
  PointCloud cloud = two_levels(0.02, 7, true);
  const auto field = field_of(cloud, 0.1, context);
  REQUIRE(field);
  const MeshDistance distance(field->mesh);
  const Vec3 middle(-40 * 0.4, 0, 300 + wave(-16, 0));
  CHECK(distance.closest(middle).distance > 5);
  CHECK(topology(field->mesh).components == 2);
}

TEST_CASE("height field: moved and turned with its sensor, the surface moves along") {
  Context context;
  const Pose pose{rotation_of({0.4, -0.8, 1.1}), Vec3(30, -500, 210)};
  PointCloud here = two_levels(0.02, 5), there = here;
  for (Vec3& p : there.points) p = pose * p;
  View view;
  view.has_sensor = true;
  view.world_from_view = pose;
  const auto a = field_of(here, 0.1, context), b = field_of(there, 0.1, context, {view});
  REQUIRE(a);
  REQUIRE(b);
  CHECK((b->towards_sensor - pose.rotation * a->towards_sensor).norm() < 0.01);
  CHECK(area(b->mesh) == Approx(area(a->mesh)).epsilon(0.003));
  const MeshDistance distance(a->mesh);
  for (const Vec3& v : b->mesh.vertices) REQUIRE(distance.closest(pose.inverse() * v).distance < 0.3);
}

TEST_CASE("height field: the order of points and the number of threads do not change a single digit") {
  Context context;
  PointCloud one = two_levels(0.02, 9), two;
  for (std::size_t i = one.size(); i-- > 0;) two.points.push_back(one.points[(i * 7919) % one.size()]);
  const auto a = field_of(one, 0.1, context);
  context.threads = 3;
  const auto b = field_of(two, 0.1, context);
  REQUIRE(a);
  REQUIRE(b);
  CHECK(a->mesh.triangles == b->mesh.triangles);
  CHECK(a->mesh.vertices == b->mesh.vertices);
}

TEST_CASE("height field: a body seen from all sides is none") {
  Context context;
  Random random(2);
  PointCloud cloud;
  for (int i = 0; i < 8000; ++i)
    cloud.points.push_back(10 * Vec3(random.normal(), random.normal(), random.normal()).normalized() + Vec3(0, 0, 200));
  CHECK_FALSE(field_of(cloud, 0.1, context));
}
