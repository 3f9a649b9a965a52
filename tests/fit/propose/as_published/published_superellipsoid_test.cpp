/// Equation (6) as published: what it recovers, what it prefers, and what it does not stand.
#include "fit/propose/as_published/published_superellipsoid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "fit/propose/superellipsoid.h"

using namespace partscribe::fit;

namespace {

const Pose scan_from_body{rotation_of(Vec3(0.4, -0.8, 0.3)), Vec3(10, 20, -5)};

Vec3 direction(Random& random) { return Vec3(random.normal(), random.normal(), random.normal()).normalized(); }

Vec3 on_ellipsoid(Random& random) {
  const Vec3 a(40, 25, 15);
  while (true) {  // thinned to even density
    const Vec3 u = direction(random);
    if (random.uniform() < 15 * Vec3(u.cwiseQuotient(a)).norm()) return u.cwiseProduct(a);
  }
}

/// Radius 20, from -30 to 30.
Vec3 on_rod(Random& random) {
  const double pick = random.uniform(0, 80), angle = random.uniform(0, 2 * pi);
  if (pick < 60) return {20 * std::cos(angle), 20 * std::sin(angle), pick - 30};
  const double r = 20 * std::sqrt(random.uniform());
  return {r * std::cos(angle), r * std::sin(angle), pick < 70 ? 30.0 : -30.0};
}

Vec3 on_block(Random& random) {
  const Vec3 a(30, 20, 12);
  const double pick = random.uniform(0, 20 * 12 + 30 * 12 + 30 * 20);
  const int face = pick < 240 ? 0 : pick < 600 ? 1 : 2;
  Vec3 p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  p[face] = random.uniform() < 0.5 ? -1 : 1;
  return p.cwiseProduct(a);
}

/// A cone's frustum of radii 25 and 10 at z = -25 and 25, with its ends.
Vec3 on_frustum_body(Random& random) {
  const double wall = 35 * 52.2, pick = random.uniform(0, wall + 25 * 25 + 10 * 10), angle = random.uniform(0, 2 * pi);
  double r, z;
  if (pick < wall) {
    do z = random.uniform(-25, 25), r = 17.5 - 0.3 * z;
    while (random.uniform() > r / 25);
  } else {
    z = pick < wall + 625 ? -25 : 25, r = (17.5 - 0.3 * z) * std::sqrt(random.uniform());
  }
  return {r * std::cos(angle), r * std::sin(angle), z};
}

template <class Draw>
std::vector<Vec3> drawn_points(Draw draw, double noise, double outliers, std::uint64_t seed,
                               const Vec3& seen_from = Vec3::Zero()) {
  Random random(seed);
  std::vector<Vec3> points;
  while (points.size() < 3000) {
    Vec3 p = draw(random);
    if (p.dot(seen_from) < 0) continue;
    p += noise * Vec3(random.normal(), random.normal(), random.normal());
    if (random.uniform() < outliers)
      p = Vec3(random.uniform(-45, 45), random.uniform(-45, 45), random.uniform(-45, 45));
    points.push_back(scan_from_body * p);
  }
  return points;
}

std::array<double, 3> sizes_of(const SuperellipsoidOf<double>& s) {
  std::array<double, 3> a = {s.a1, s.a2, s.a3};
  std::sort(a.begin(), a.end());
  return a;
}

/// Without taper: 2 a1 a2 a3 e1 e2 B(e1/2 + 1, e1) B(e2/2, e2/2).
double volume_of(const SuperellipsoidOf<double>& s) {
  const auto beta = [](double a, double b) { return std::tgamma(a) * std::tgamma(b) / std::tgamma(a + b); };
  return 2 * s.a1 * s.a2 * s.a3 * s.e1 * s.e2 * beta(s.e1 / 2 + 1, s.e1) * beta(s.e2 / 2, s.e2 / 2);
}

}  // namespace

TEST_CASE("published superellipsoid: ellipsoid, cylinder and box come back from all around, with sizes and exponents") {
  const auto ellipsoid = published_superellipsoid(drawn_points(on_ellipsoid, 0.2, 0, 1), {});
  REQUIRE(ellipsoid);
  CHECK(ellipsoid->converged);
  CHECK(sizes_of(ellipsoid->shape)[0] == Approx(15).margin(0.15));
  CHECK(sizes_of(ellipsoid->shape)[1] == Approx(25).margin(0.15));
  CHECK(sizes_of(ellipsoid->shape)[2] == Approx(40).margin(0.3));
  CHECK(ellipsoid->shape.e1 == Approx(1).margin(0.03));
  CHECK(ellipsoid->shape.e2 == Approx(1).margin(0.03));
  CHECK((ellipsoid->scan_from_shape.translation - scan_from_body.translation).norm() < 0.1);
  CHECK(ellipsoid->gof < 0.03);

  const auto rod = published_superellipsoid(drawn_points(on_rod, 0.2, 0, 2), {});
  REQUIRE(rod);
  CHECK(rod->shape.a3 == Approx(30).margin(0.3));
  CHECK(rod->shape.a1 == Approx(20).margin(0.15));
  CHECK(rod->shape.a2 == Approx(20).margin(0.15));
  CHECK(rod->shape.e1 < 0.15);
  CHECK(rod->shape.e2 == Approx(1).margin(0.05));
  CHECK(std::abs(rod->scan_from_shape.rotation.col(2).dot(scan_from_body.rotation.col(2))) > 0.9999);

  const auto block = published_superellipsoid(drawn_points(on_block, 0.2, 0, 3), {});
  REQUIRE(block);
  CHECK(sizes_of(block->shape)[0] == Approx(12).margin(0.2));
  CHECK(sizes_of(block->shape)[1] == Approx(20).margin(0.2));
  CHECK(sizes_of(block->shape)[2] == Approx(30).margin(0.3));
  CHECK(block->shape.e1 < 0.15);
  CHECK(block->shape.e2 < 0.15);
}

TEST_CASE("published superellipsoid: no body near the one found has a smaller (6), and (6) is what equation (5) says") {
  const auto points = drawn_points(on_ellipsoid, 0.5, 0, 4);
  const auto found = published_superellipsoid(points, {});
  REQUIRE(found);
  const auto& s = found->shape;
  double sum = 0;
  for (const Vec3& p : points) {
    const Vec3 q = found->scan_from_shape.inverse() * p;
    const double across = std::pow(std::abs(q.x() / s.a1), 2 / s.e2) + std::pow(std::abs(q.y() / s.a2), 2 / s.e2);
    const double f = std::pow(std::pow(across, s.e2 / s.e1) + std::pow(std::abs(q.z() / s.a3), 2 / s.e1), s.e1);
    sum += s.a1 * s.a2 * s.a3 * (f - 1) * (f - 1);
  }
  CHECK(found->objective == Approx(sum).epsilon(1e-9));
  CHECK(equation_six(s, found->scan_from_shape, points) == Approx(sum).epsilon(1e-9));
  for (const double step : {-0.02, 0.02}) {
    for (int k = 0; k < 5; ++k) {
      SuperellipsoidOf<double> other = s;
      (k == 0 ? other.a1 : k == 1 ? other.a2 : k == 2 ? other.a3 : k == 3 ? other.e1 : other.e2) *= 1 + step;
      CHECK(equation_six(other, found->scan_from_shape, points) > found->objective);
    }
    for (int k = 0; k < 3; ++k) {
      Pose moved = found->scan_from_shape, turned = moved;
      moved.translation[k] += 10 * step;
      turned.rotation = rotation_of(step * Vec3::Unit(k)) * turned.rotation;
      CHECK(equation_six(s, moved, points) > found->objective);
      CHECK(equation_six(s, turned, points) > found->objective);
    }
  }
  // In other units the same body, and (6) as a volume.
  auto metres = points;
  for (Vec3& p : metres) p /= 1000;
  const auto small = published_superellipsoid(metres, {});
  REQUIRE(small);
  CHECK(1000 * small->shape.a3 == Approx(s.a3).epsilon(1e-6));
  CHECK(1e9 * small->objective == Approx(found->objective).epsilon(1e-6));
  CHECK(small->gof == Approx(found->gof).epsilon(1e-6));
}

TEST_CASE(
    "published superellipsoid: of bodies that explain one side of a rod it prefers the small one, ours does not") {
  partscribe::core::Context context;
  for (const std::uint64_t seed : {5, 6}) {
    const auto points = drawn_points(on_rod, 0.2, 0, seed, Vec3(0.6, 0.5, 0.62));
    const auto published = published_superellipsoid(points, {});
    REQUIRE(published);
    const SuperellipsoidFit ours = recover_superellipsoid(points, context);
    const double true_volume = pi * 400 * 60;
    INFO("volumes " << volume_of(published->shape) / true_volume << " " << volume_of(ours.shape) / true_volume);
    CHECK(volume_of(published->shape) < 0.95 * true_volume);
    CHECK(volume_of(published->shape) < 0.98 * volume_of(ours.shape));
    CHECK(std::abs(volume_of(ours.shape) - true_volume) < std::abs(volume_of(published->shape) - true_volume));
    // It is the factor a1 a2 a3 that decides: by the sum of (F - 1)^2 alone ours is the better one.
    const double six = equation_six(ours.shape, ours.scan_from_shape, points);
    const double factor = ours.shape.a1 * ours.shape.a2 * ours.shape.a3;
    CHECK(six > published->objective);
    CHECK(six / factor < published->objective / (published->shape.a1 * published->shape.a2 * published->shape.a3));
  }
}

TEST_CASE("published superellipsoid: a tenth of outliers spoils it, and not the mixture") {
  partscribe::core::Context context;
  const auto points = drawn_points(on_ellipsoid, 0.2, 0.1, 7);
  const auto published = published_superellipsoid(points, {});
  REQUIRE(published);
  const double true_volume = 4 * pi / 3 * 40 * 25 * 15;
  CHECK(volume_of(published->shape) > 1.5 * true_volume);
  CHECK(volume_of(recover_superellipsoid(points, context).shape) == Approx(true_volume).epsilon(0.02));
}

TEST_CASE("published superellipsoid: a taper is fitted where it is asked for") {
  const auto points = drawn_points(on_frustum_body, 0.1, 0, 8);
  const auto straight = published_superellipsoid(points, {}),
             tapered = published_superellipsoid(points, {.taper = true});
  REQUIRE(straight);
  REQUIRE(tapered);
  CHECK(straight->shape.taper_x == 0);
  CHECK(tapered->objective < 0.1 * straight->objective);
  CHECK(std::abs(tapered->shape.taper_x) == Approx(7.5 / 17.5).margin(0.03));
  CHECK(tapered->shape.taper_x == Approx(tapered->shape.taper_y).margin(0.02));
}

TEST_CASE("published superellipsoid: bad_points say what was expected") {
  auto points = drawn_points(on_block, 0, 0, 9);
  CHECK(published_superellipsoid({points.begin(), points.begin() + 12}, {}).error().message ==
        "expected at least 20 points of a body, found 12");
  for (Vec3& p : points) p.z() = 4;
  CHECK(published_superellipsoid(points, {}).error().message == "expected points of a body, found 3000 in a plane");
}
