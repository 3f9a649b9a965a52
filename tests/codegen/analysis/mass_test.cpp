/// Mass properties against closed forms, and against sums over triangles.
#include "codegen/analysis/mass.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>

#include "codegen/exchange/brep.h"
#include "testing/checked_model.h"
#include "testing/models.h"
#include "verify/exchange/mesh_shape.h"

namespace partscribe::testing {

using namespace codegen;

namespace {

MassProperties mass_of(Model m) {
  Context context;
  const auto mass = mass_properties(checked_model(std::move(m)), context);
  INFO((mass ? "" : mass.error().message));
  REQUIRE(mass.ok());
  return *mass;
}

void check_inertia(const Mat3& found, const Mat3& expected, double share) {
  INFO(found << "\nexpected\n" << expected);
  CHECK((found - expected).cwiseAbs().maxCoeff() <= share * expected.cwiseAbs().maxCoeff());
}

Mat3 diagonal(double x, double y, double z) { return Vec3(x, y, z).asDiagonal(); }

/// By the divergence theorem, triangle by triangle: each is the base of a tetrahedron at the origin.
MassProperties of_triangles(const TriangleMesh& mesh) {
  MassProperties sum;
  Mat3 second = Mat3::Zero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
    const double six_volumes = a.dot(b.cross(c));
    sum.volume += six_volumes / 6;
    sum.centroid += six_volumes / 24 * (a + b + c);
    const Vec3 s = a + b + c;
    second += six_volumes / 120 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
  }
  sum.centroid /= sum.volume;
  second -= sum.volume * sum.centroid * sum.centroid.transpose();
  sum.inertia = second.trace() * Mat3::Identity() - second;
  return sum;
}

}  // namespace

TEST_CASE("mass: a box has the volume, surface, centroid and inertia of the textbook") {
  const auto mass = mass_of(model_with(Box{30, 20, 10}));
  CHECK(mass.volume == Approx(6000).epsilon(1e-12));
  CHECK(mass.area == Approx(2200).epsilon(1e-12));
  CHECK((mass.centroid - Vec3(15, 10, 5)).norm() < 1e-10);
  check_inertia(mass.inertia, diagonal(500 * (400 + 100), 500 * (900 + 100), 500 * (900 + 400)), 1e-12);
}

TEST_CASE("mass: a cylinder with a hole along its axis") {
  const double outer = 12, inner = 5, height = 30;
  Model tube;
  tube.objects = {{"rod", Cylinder{outer, height}, {}, {}, {}},
                  {"drill", Cylinder{inner, height + 2}, {0, 0, -1, 0, 0, 0}, {}, {}},
                  {"tube", Difference{{"rod", "drill"}}, {}, {}, {}}};
  const auto mass = mass_of(tube);
  const double ring = outer * outer - inner * inner, square = outer * outer + inner * inner;
  const double volume = pi * ring * height;
  CHECK(mass.volume == Approx(volume).epsilon(1e-9));
  CHECK(mass.area == Approx(2 * pi * (outer + inner) * height + 2 * pi * ring).epsilon(1e-9));
  CHECK((mass.centroid - Vec3(0, 0, 15)).norm() < 1e-8);
  const double across = volume * (3 * square + height * height) / 12;
  check_inertia(mass.inertia, diagonal(across, across, volume * square / 2), 1e-9);
  const auto principal = principal_moments(mass.inertia);
  CHECK(principal.moments[0] == Approx(volume * square / 2).epsilon(1e-9));
  CHECK(std::abs(principal.axes(2, 0)) == Approx(1).epsilon(1e-12));
}

TEST_CASE("mass: a sphere, an ellipsoid and a torus have their closed forms") {
  const double r = 11, ball_volume = 4 * pi * r * r * r / 3;
  const auto ball = mass_of(model_with(Sphere{r}));
  CHECK(ball.volume == Approx(ball_volume).epsilon(1e-10));
  CHECK(ball.area == Approx(4 * pi * r * r).epsilon(1e-10));
  check_inertia(ball.inertia, 0.4 * ball_volume * r * r * Mat3::Identity(), 1e-10);

  const double egg_volume = 4 * pi / 3 * 20 * 12 * 8;
  const auto egg = mass_of(model_with(Ellipsoid{20, 12, 8}));
  CHECK(egg.volume == Approx(egg_volume).epsilon(1e-8));
  check_inertia(egg.inertia, egg_volume / 5 * diagonal(144 + 64, 400 + 64, 400 + 144), 1e-8);

  const double ring_volume = 2 * pi * pi * 20 * 36;
  const auto ring = mass_of(model_with(Torus{20, 6}));
  CHECK(ring.volume == Approx(ring_volume).epsilon(1e-10));
  const double across = ring_volume * (4 * 400 + 5 * 36) / 8;
  check_inertia(ring.inertia, diagonal(across, across, ring_volume * (400 + 0.75 * 36)), 1e-10);
}

TEST_CASE("mass: turning and moving a part turns and moves what it has, even kilometres away") {
  Model moved = model_with(Box{30, 20, 10});
  moved.scan_from_part = {2e6, -3e6, 1e6, 0.3, -0.8, 2.1};
  const auto mass = mass_of(moved);
  const Mat3 turn = rotation_from_euler({0.3, -0.8, 2.1});
  CHECK((mass.centroid - (turn * Vec3(15, 10, 5) + Vec3(2e6, -3e6, 1e6))).norm() < 1e-6);
  check_inertia(mass.inertia, turn * diagonal(250000, 500000, 650000) * turn.transpose(), 1e-7);
  const auto principal = principal_moments(mass.inertia);
  CHECK(principal.moments[0] == Approx(250000).epsilon(1e-7));
  CHECK(principal.moments[2] == Approx(650000).epsilon(1e-7));
  CHECK(std::abs(principal.axes.col(0).dot(turn.col(0))) == Approx(1).epsilon(1e-9));
  CHECK(principal.axes.determinant() == Approx(1).epsilon(1e-12));
  moved.as_scanned = false;
  CHECK((mass_of(moved).centroid - Vec3(15, 10, 5)).norm() < 1e-10);
}

TEST_CASE("mass: where moments are equal the axes are those of the frame, and not what rounding makes of them") {
  const Mat3 noise = (Mat3() << 0, 1, -2, 1, 0, 3, -2, 3, 0).finished() * 1e-9;
  CHECK(principal_moments(100 * Mat3::Identity() + noise).axes.isApprox(Mat3::Identity(), 1e-12));
  const auto turned = principal_moments(diagonal(100, 100, 40) + noise);
  CHECK(std::abs(turned.axes(2, 0)) == Approx(1).epsilon(1e-9));
  CHECK(turned.axes.col(1).isApprox(Vec3::UnitX(), 1e-9));
}

TEST_CASE("mass: of every solid shape agrees with the sum over its triangles") {
  Context context;
  int solids = 0;
  for (const Model& m : one_of_each()) {
    const auto model = checked_model(m);
    if (is_sheet(m.objects.back().shape)) continue;
    ++solids;
    INFO(kind_of(m.objects.back().shape));
    const auto body = build_body(model, context);
    REQUIRE(body.ok());
    const auto mass = mass_properties(*body->shape);
    const auto expected = of_triangles(verify::mesh_shape(*body->shape, 0.3).mesh);
    CHECK(mass.volume == Approx(expected.volume).epsilon(1e-2));
    CHECK((mass.centroid - expected.centroid).norm() < 0.05);
    check_inertia(mass.inertia, expected.inertia, 2e-2);
  }
  CHECK(solids > 30);
}

TEST_CASE("mass: bad_input: an open surface has no volume, and one line says so") {
  Context context;
  const auto mass = mass_properties(checked_model(model_with(cowl())), context);
  REQUIRE_FALSE(mass.ok());
  CHECK(mass.error().kind == ErrorKind::bad_input);
  CHECK(mass.error().message ==
        "object 'body': expected a solid, found an open surface_set, which has a surface but no volume");
}

}  // namespace partscribe::testing
