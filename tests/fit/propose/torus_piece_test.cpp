#include "fit/propose/torus_piece.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"

using namespace partscribe::fit;

namespace {

/// Points and normals of `surface(u, v)`, u and v in [-1, 1], with noise along the normal.
template <class Surface>
FitInput seen(const Surface& surface, double noise, double outliers) {
  Random random(7);
  const Pose place{rotation_of({0.4, -0.7, 0.3}), {30, -12, 55}};
  FitInput input;
  for (int i = 0; i < 3000; ++i) {
    const auto [point, normal] = surface(random.uniform(-1, 1), random.uniform(-1, 1));
    const double off = random.uniform() < outliers ? random.uniform(-20, 20) : noise * random.normal();
    input.cloud.points.push_back(place * Vec3(point + off * normal));
    input.cloud.normals.push_back(place.rotation * normal);
  }
  input.bounds = input.cloud.bounds();
  input.sampling.sigma = noise, input.tolerance = 3 * noise;
  return input;
}

std::pair<Vec3, Vec3> of_torus(double ring, double tube, double about_axis, double about_tube) {
  const Vec3 out(std::cos(about_axis), std::sin(about_axis), 0);
  const Vec3 normal = std::cos(about_tube) * out + std::sin(about_tube) * Vec3::UnitZ();
  return {ring * out + tube * normal, normal};
}

}  // namespace

TEST_CASE("torus: a twelfth of its outer side tells ring and tube") {
  for (const double outliers : {0.0, 0.1}) {
    const FitInput input = seen([](double u, double v) { return of_torus(30, 18, 0.26 * u, 1.2 * v); }, 0.1, outliers);
    const auto found = propose_torus_piece(input);
    REQUIRE(found.size() == 1);
    INFO("outliers " << outliers);
    CHECK(found[0].parameters[0].value == Approx(30).margin(1));
    CHECK(found[0].parameters[1].value == Approx(18).margin(0.3));
  }
}

TEST_CASE("torus: a piece of a ball or of a block is none") {
  const auto ball = [](double u, double v) {
    const Vec3 n(std::cos(0.5 * u) * std::cos(0.5 * v), std::sin(0.5 * u) * std::cos(0.5 * v), std::sin(0.5 * v));
    return std::pair<Vec3, Vec3>{20 * n, n};
  };
  CHECK(propose_torus_piece(seen(ball, 0.1, 0)).empty());
  const auto corner = [](double u, double v) {
    return u < 0 ? std::pair<Vec3, Vec3>{{20 * u, 20 * v, 0}, Vec3::UnitZ()}
                 : std::pair<Vec3, Vec3>{{0, 20 * v, -20 * u}, Vec3::UnitX()};
  };
  CHECK(propose_torus_piece(seen(corner, 0.1, 0)).empty());
}
