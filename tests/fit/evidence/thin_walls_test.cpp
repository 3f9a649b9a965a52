/// Numbers of parts that run out in walls thinner than the noise.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "fit/refine/refine.h"

using namespace partscribe::fit;

namespace {

constexpr double radius = 20, length = 30, noise = 0.3;

/// The three long faces of a round fillet. No ray tells which side of its cusps a point was seen from.
FitInput cusps(std::uint64_t seed) {
  FitInput input;
  Random random(seed);
  for (int i = 0; i < 3600; ++i) {
    const double at = random.uniform(), z = length * random.uniform(), d = noise * random.normal();
    Vec3 p(radius * at, 0, z), n(0, -1, 0);
    if (i % 3 == 1) p = {0, radius * at, z}, n = {-1, 0, 0};
    if (i % 3 == 2) n = {std::sin(pi / 2 * at), std::cos(pi / 2 * at), 0}, p = Vec3(radius, radius, z) - radius * n;
    input.cloud.points.push_back(p + d * n), input.cloud.normals.push_back(n);
  }
  input.bounds = input.cloud.bounds();
  input.sampling.sigma = noise, input.tolerance = 3 * noise, input.thin_spacing = 0.5;
  return input;
}

double fitted_radius(std::uint64_t seed) {
  Candidate c;
  c.procedure = "fillet", c.object_name = "fillet_body";
  c.shape = Fillet{Expr::of("radius"), Expr::of("radius"), Expr(length)};
  Parameter p;
  p.name = "radius", p.quantity = Quantity::length, p.value = p.fitted = 1.01 * radius;
  c.parameters.push_back(p);
  Context context;
  refine(c, cusps(seed), {}, context);
  return c.parameters[0].value;
}

}  // namespace

TEST_CASE("thin walls: points in cusps that no ray tells apart count for both sides") {
  double sum = 0, squares = 0;
  constexpr int runs = 12;
  for (int seed = 1; seed <= runs; ++seed) {
    const double error = fitted_radius(static_cast<std::uint64_t>(seed)) - radius;
    sum += error, squares += error * error;
  }
  INFO("mean " << sum / runs << " rms " << std::sqrt(squares / runs));
  CHECK(std::abs(sum / runs) < 0.04);
  CHECK(std::sqrt(squares / runs) < 0.07);
}
