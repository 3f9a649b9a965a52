/// Clouds without rays whose points are far denser than their noise is thick: what is near a point is a ball of noise.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "fit/build.h"

using namespace partscribe::fit;

namespace {

/// A rod about an axis askew, closed by two flat ends.
Scan rod(std::size_t points, double radius, double length, double noise) {
  Random random(5);
  const Mat3 turn = rotation_of({0.4, -0.3, 0.9});
  const double side = 2 * pi * radius * length, end = pi * radius * radius;
  Scan scan;
  scan.files = {"scan"};
  for (std::size_t i = 0; i < points; ++i) {
    const double part = random.uniform() * (side + 2 * end), angle = random.uniform(0, 2 * pi),
                 off = noise * random.normal();
    const Vec3 out(std::cos(angle), std::sin(angle), 0);
    const double r = radius * std::sqrt(random.uniform());
    const Vec3 p = part < side         ? Vec3((radius + off) * out + Vec3(0, 0, random.uniform(0, length)))
                   : part < side + end ? Vec3(r * out + Vec3(0, 0, -off))
                                       : Vec3(r * out + Vec3(0, 0, length + off));
    scan.cloud.points.push_back(turn * p);
  }
  return scan;
}

void check_rod(const Scan& scan, double radius, double length, double tolerance) {
  Scan copy = scan;
  BuildOptions options;
  options.tolerance = tolerance, options.nominal = false;
  Context context;
  const auto model = build_model(copy, options, context);
  REQUIRE(model);
  REQUIRE(std::holds_alternative<Cylinder>((*model)->objects.back().shape));
  for (const Parameter& p : (*model)->parameters) {
    const double truth = p.name == "diameter" ? 2 * radius : length;
    INFO(p.name << ' ' << p.fitted << " +- " << p.sigma);
    CHECK(std::abs(p.fitted - truth) < 3 * p.sigma);
    CHECK(p.sigma < 0.01 * radius);
  }
}

}  // namespace

TEST_CASE("build: a rod whose nearest points are nearer to each other than the noise is a cylinder") {
  constexpr double radius = 10, length = 20, noise = 0.5;
  const Scan scan = rod(8000, radius, length, noise);
  for (const double sigmas : {5.0, 2.5}) {
    INFO(sigmas << " sigmas");
    check_rod(scan, radius, length, sigmas * noise);
  }
}
