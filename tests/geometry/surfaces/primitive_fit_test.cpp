#include "geometry/surfaces/primitive_fit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"
#include "testing/primitives.h"

using namespace partscribe::geometry;
namespace scenes = partscribe::testing::primitives;
using scenes::example, scenes::kinds;

namespace {

Vec3 direction(Random& random) { return Vec3(random.normal(), random.normal(), random.normal()).normalized(); }

/// Error over sigma of every number that the kind has.
std::vector<double> scores(const PrimitiveFit& fit, const Primitive& truth) {
  const Primitive& p = fit.primitive;
  std::vector<double> z;
  const auto add = [&](double error, double sigma) { z.push_back(error / sigma); };
  const Vec3 away = p.point - truth.point;
  const double along = away.dot(truth.axis);
  const Vec3 side = truth.axis.unitOrthogonal(), axis = p.axis.dot(truth.axis) < 0 ? Vec3(-p.axis) : p.axis;
  switch (p.kind) {
    case PrimitiveKind::plane:
      add(along, fit.sigma_point);
      break;
    case PrimitiveKind::line:
      add(away.dot(side), fit.sigma_point);
      break;
    case PrimitiveKind::cone:
      // The radius is that of the true cone beside the fitted point.
      add(p.radius - truth.radius - along * std::tan(truth.half_angle), fit.sigma_radius);
      add(p.half_angle - truth.half_angle, fit.sigma_half_angle);
      break;
    case PrimitiveKind::torus:
      add(p.tube - truth.tube, fit.sigma_tube);
      [[fallthrough]];
    default:
      add(p.radius - truth.radius, fit.sigma_radius);
  }
  if (p.kind != PrimitiveKind::sphere) add((axis - truth.axis).dot(side), fit.sigma_axis);
  return z;
}

double largest_distance(const Primitive& p, const std::vector<Vec3>& points) {
  double largest = 0;
  for (const Vec3& q : points) largest = std::max(largest, std::abs(distance(p, q)));
  return largest;
}

PrimitiveFit fitted(PrimitiveKind kind, const scenes::Scan& scan, const PrimitiveFitOptions& options = {}) {
  const auto fit = fit_primitive(kind, scan.points, {}, options);
  REQUIRE(fit);
  return *fit;
}

}  // namespace

TEST_CASE("primitive fit: every kind is recovered within four of the sigmas that it states") {
  Random random(1);
  for (const PrimitiveKind kind : kinds)
    for (const double arc : {2 * pi, pi / 3})
      for (int trial = 0; trial < 10; ++trial) {
        const Primitive truth = example(kind, 100, random);
        const scenes::Scan scan = scenes::scan(truth, 500, arc, 0.02, random);
        const PrimitiveFit fit = fitted(kind, scan);
        INFO(name_of(kind) << " over " << degrees(arc) << " degrees");
        CHECK(fit.converged);
        CHECK(fit.determined);
        for (const double z : scores(fit, truth)) CHECK(std::abs(z) < 4.2);
      }
}

TEST_CASE("primitive fit: radii scatter as the Cramer-Rao bound says") {
  // Bounds of a full circle: sphere and circle var r = s^2/n (1 + ...) have closed forms; n = 500, s = 0.02.
  Random random(2);
  for (const PrimitiveKind kind : {PrimitiveKind::circle, PrimitiveKind::sphere, PrimitiveKind::cylinder}) {
    double sum = 0;
    const int trials = 300;
    for (int trial = 0; trial < trials; ++trial) {
      const Primitive truth = example(kind, 100, random);
      const double error = fitted(kind, scenes::scan(truth, 500, 2 * pi, 0.02, random)).primitive.radius - truth.radius;
      sum += error * error;
    }
    const double bound = 0.02 / std::sqrt(500.0);
    INFO(name_of(kind));
    CHECK(std::sqrt(sum / trials) == Approx(bound).epsilon(0.12));
  }
}

TEST_CASE("primitive fit: intervals of 95 % cover the truth in 95 of 100 scans") {
  Random random(3);
  for (const PrimitiveKind kind : kinds) {
    int inside = 0, all = 0;
    for (int trial = 0; trial < 1200; ++trial) {
      const Primitive truth = example(kind, 100, random);
      const scenes::Scan scan = scenes::scan(truth, 200, trial % 2 ? pi / 3 : 2 * pi, 0.02, random);
      PrimitiveFitOptions options;
      options.start = truth;
      options.sigma = trial % 3 ? 0 : 0.02;  // estimated or given
      const std::vector<double> z = scores(fitted(kind, scan, options), truth);
      // Direction last: its sigma is the largest over tilts, so it covers more often; it is not counted here.
      const std::size_t own = kind == PrimitiveKind::sphere ? z.size() : z.size() - 1;
      for (std::size_t i = 0; i < own; ++i) ++all, inside += std::abs(z[i]) < 1.96;
    }
    INFO(name_of(kind) << " " << inside << " of " << all);
    CHECK(inside >= 0.92 * all);
    CHECK(inside <= 0.98 * all);
  }
}

TEST_CASE("primitive fit: a hundred metres from the origin exact points give exact numbers") {
  Random random(4);
  for (const PrimitiveKind kind : kinds) {
    const Primitive truth = example(kind, 1e5, random);
    const scenes::Scan scan = scenes::scan(truth, 1000, 2 * pi, 0, random);
    const PrimitiveFit fit = fitted(kind, scan);
    INFO(name_of(kind));
    CHECK(std::abs(fit.primitive.radius - truth.radius -
                   (kind == PrimitiveKind::cone
                        ? (fit.primitive.point - truth.point).dot(truth.axis) * std::tan(truth.half_angle)
                        : 0)) < 1e-9);
    CHECK(std::abs(fit.primitive.tube - truth.tube) < 1e-9);
    CHECK(std::abs(fit.primitive.half_angle - truth.half_angle) < 1e-10);
    CHECK(largest_distance(fit.primitive, scan.points) < 1e-9);
    CHECK(fit.rms < 1e-7);
  }
}

TEST_CASE("primitive fit: the basin reaches starts a radian and half the size away") {
  Random random(5);
  for (const PrimitiveKind kind : kinds)
    for (int trial = 0; trial < 30; ++trial) {
      const Primitive truth = example(kind, 100, random);
      const scenes::Scan scan = scenes::scan(truth, 300, 2 * pi, 0.02, random);
      PrimitiveFitOptions options;
      options.start = truth;
      options.start->axis = rotation_of(direction(random).cross(truth.axis).normalized()) * truth.axis;
      options.start->radius *= trial % 2 ? 1.5 : 0.5;
      options.start->tube *= trial % 4 < 2 ? 1.5 : 0.5;
      options.start->half_angle *= trial % 4 < 2 ? 1.5 : 0.5;
      INFO(name_of(kind) << " " << trial);
      CHECK(fitted(kind, scan, options).rms < 0.035);
    }
}

TEST_CASE("primitive fit: the order of the points moves only the last bits") {
  Random random(6);
  for (const PrimitiveKind kind : kinds) {
    const Primitive truth = example(kind, 100, random);
    scenes::Scan scan = scenes::scan(truth, 3000, pi, 0.02, random);
    const Primitive a = fitted(kind, scan).primitive;
    for (std::size_t i = scan.points.size() - 1; i > 0; --i)
      std::swap(scan.points[i], scan.points[random.below(i + 1)]);
    const Primitive b = fitted(kind, scan).primitive;
    INFO(name_of(kind));
    CHECK(std::abs(a.radius - b.radius) < 1e-8);
    CHECK(std::abs(a.tube - b.tube) < 1e-8);
    CHECK(std::abs(a.half_angle - b.half_angle) < 1e-9);
    CHECK((a.point - b.point).norm() < 1e-7);
    CHECK((a.axis - b.axis).norm() < 1e-9);
  }
}

TEST_CASE("primitive fit: too few points and undefined numbers give no fit") {
  Random random(7);
  for (const PrimitiveKind kind : kinds) {
    INFO(name_of(kind));
    CHECK_FALSE(fit_primitive(kind, {}, {}, {}));
    CHECK_FALSE(fit_primitive(kind, {Vec3::Zero()}, {}, {}));
    scenes::Scan scan = scenes::scan(example(kind, 10, random), 100, 2 * pi, 0.02, random);
    scan.points[57].y() = std::nan("");
    CHECK_FALSE(fit_primitive(kind, scan.points, {}, {}));
    scan.points[57].y() = INFINITY;
    CHECK_FALSE(fit_primitive(kind, scan.points, {}, {}));
  }
}

TEST_CASE("primitive fit: data that leave a number open are called undetermined") {
  Random random(8);
  std::vector<Vec3> same(50, Vec3(1, 2, 3)), straight, flat;
  for (int i = 0; i < 400; ++i) {
    const double x = random.uniform(-10, 10), y = random.uniform(-10, 10);
    straight.emplace_back(x, 2 * x, -x);
    flat.emplace_back(x, y, 0.01 * random.normal());
  }
  const auto open = [](PrimitiveKind kind, const std::vector<Vec3>& points) {
    const auto fit = fit_primitive(kind, points, {}, {});
    return !fit || !fit->determined;
  };
  for (const PrimitiveKind kind : kinds) {
    INFO(name_of(kind));
    CHECK(open(kind, same));
    if (kind != PrimitiveKind::line) CHECK(open(kind, straight));
    if (kind == PrimitiveKind::sphere || kind == PrimitiveKind::cylinder) CHECK(open(kind, flat));
  }
}

TEST_CASE("primitive fit: a stated noise of half the true one is found out by the coverage") {
  Random random(9);
  int inside = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Primitive truth = example(PrimitiveKind::cylinder, 100, random);
    PrimitiveFitOptions options;
    options.sigma = 0.01;
    options.start = truth;
    inside +=
        std::abs(scores(fitted(truth.kind, scenes::scan(truth, 200, pi, 0.02, random), options), truth)[0]) < 1.96;
  }
  CHECK(inside < 160);
}

TEST_CASE("primitive fit: nearly flat, nearly straight and nearly round data keep their numbers") {
  struct Case {
    const char* name;
    PrimitiveKind kind;
    double radius, tube, half_angle, arc;
  };
  const Case cases[] = {
      {"sphere of a metre, 40 mm of it", PrimitiveKind::sphere, 1000, 0, 0, 0.04},
      {"10 degrees of a cylinder", PrimitiveKind::cylinder, 20, 0, 0, radians(10)},
      {"5 degrees of a circle", PrimitiveKind::circle, 100, 0, 0, radians(5)},
      {"cone of 1 degree", PrimitiveKind::cone, 20, 0, radians(1), 2 * pi},
      {"a third of a cone of 1 degree", PrimitiveKind::cone, 20, 0, radians(1), 2 * pi / 3},
      {"cone of 80 degrees", PrimitiveKind::cone, 100, 0, radians(80), 2 * pi},
      {"torus that is nearly a sphere", PrimitiveKind::torus, 0.5, 10, 0, 2 * pi},
      {"torus with hardly a hole", PrimitiveKind::torus, 10.1, 10, 0, 2 * pi},
  };
  Random random(10);
  for (const Case& c : cases)
    for (int trial = 0; trial < 8; ++trial) {
      Primitive truth = example(c.kind, 100, random);
      truth.radius = c.radius, truth.tube = c.tube, truth.half_angle = c.half_angle;
      const PrimitiveFit fit = fitted(c.kind, scenes::scan(truth, 2000, c.arc, 0.01, random));
      INFO(c.name);
      CHECK(fit.converged);
      CHECK(fit.determined);
      CHECK(fit.rms < 0.016);
      for (const double z : scores(fit, truth)) CHECK(std::abs(z) < 4.5);
    }
}

TEST_CASE("primitive fit: robust weights see through one wild point in five") {
  Random random(11);
  for (const PrimitiveKind kind : kinds)
    for (int trial = 0; trial < 12; ++trial) {
      const Primitive truth = example(kind, 100, random);
      scenes::Scan scan = scenes::scan(truth, 500, trial % 2 ? pi / 2 : 2 * pi, 0.02, random);
      for (std::size_t i = 0; i < scan.points.size(); i += 5)
        scan.points[i] += Vec3(random.uniform(-10, 10), random.uniform(-10, 10), random.uniform(-10, 10));
      PrimitiveFitOptions options;
      options.robust = 2.5;
      options.sigma = trial % 3 ? 0 : 0.02;
      INFO(name_of(kind) << " " << trial);
      const PrimitiveFit fit = fitted(kind, scan, options);
      CHECK(fit.converged);
      for (const double z : scores(fit, truth)) CHECK(std::abs(z) < 4.5);
      // Plain least squares is far off here: what the weights are for.
      options.robust = 0;
      CHECK(fitted(kind, scan, options).rms > 0.5);
    }
}

TEST_CASE("primitive fit: points with a sigma of their own count by it") {
  Random random(12);
  for (const PrimitiveKind kind : kinds) {
    const Primitive truth = example(kind, 100, random);
    scenes::Scan scan = scenes::scan(truth, 400, 2 * pi, 0.02, random);
    const scenes::Scan rough = scenes::scan(truth, 400, 2 * pi, 0.5, random);
    const PrimitiveFit good = fitted(kind, scan);
    scan.points.insert(scan.points.end(), rough.points.begin(), rough.points.end());
    std::vector<double> sigmas(800, 0.02);
    std::fill(sigmas.begin() + 400, sigmas.end(), 0.5);
    PrimitiveFitOptions options;
    options.sigmas = &sigmas;
    const PrimitiveFit both = fitted(kind, scan, options);
    INFO(name_of(kind));
    for (const double z : scores(both, truth)) CHECK(std::abs(z) < 4.2);
    CHECK(both.sigma_point == Approx(good.sigma_point).epsilon(0.15));
    CHECK(both.sigma_radius == Approx(good.sigma_radius).epsilon(0.15));
    options.sigmas = nullptr;
    CHECK(fitted(kind, scan, options).sigma_point > 5 * both.sigma_point);
  }
}

TEST_CASE("primitive fit: a point behind a cone's apex is as far as the apex") {
  Primitive cone;
  cone.kind = PrimitiveKind::cone;
  cone.half_angle = pi / 4;
  cone.radius = 5;
  CHECK(distance(cone, Vec3(0, 0, -8)) == Approx(3));
  CHECK(distance(cone, Vec3(5, 0, 0)) == Approx(0).margin(1e-12));
  CHECK(distance(cone, Vec3(0, 0, 0)) == Approx(-5 / std::sqrt(2.0)));
}

TEST_CASE("primitive fit: planes look along the normals, and starts keep their sense") {
  Random random(13);
  for (const double sense : {1.0, -1.0}) {
    Primitive truth = example(PrimitiveKind::plane, 10, random);
    scenes::Scan scan = scenes::scan(truth, 100, 2 * pi, 0.02, random);
    for (Vec3& n : scan.normals) n *= sense;
    const auto fit = fit_primitive(PrimitiveKind::plane, scan.points, scan.normals, {});
    REQUIRE(fit);
    CHECK(fit->primitive.axis.dot(sense * truth.axis) > 0.999);
    truth = example(PrimitiveKind::cylinder, 10, random);
    PrimitiveFitOptions options;
    options.start = truth;
    options.start->axis *= sense;
    CHECK(fitted(truth.kind, scenes::scan(truth, 100, 2 * pi, 0.02, random), options)
              .primitive.axis.dot(sense * truth.axis) > 0.999);
  }
}

TEST_CASE("primitive fit: a grid of scan lines is sampled across its lines") {
  // 512 lines of 512 points: every 512th point alone would be one line along the axis.
  Random random(14);
  std::vector<Vec3> grid;
  for (int line = 0; line < 512; ++line)
    for (int i = 0; i < 512; ++i) {
      const double a = 0.004 * (i - 256);
      const double r = 20 + 0.02 * random.normal();
      grid.emplace_back(r * std::cos(a), r * std::sin(a), 0.1 * (line - 256));
    }
  const auto fit = fit_primitive(PrimitiveKind::cylinder, grid, {}, {});
  REQUIRE(fit);
  CHECK(fit->converged);
  CHECK(fit->primitive.radius == Approx(20).margin(0.001));
}

TEST_CASE("primitive fit: whatever the points, the numbers are finite") {
  Random random(15);
  for (int trial = 0; trial < 400; ++trial) {
    const PrimitiveKind kind = kinds[random.below(7)];
    Primitive truth = example(kinds[random.below(7)], std::pow(10, random.uniform(-3, 6)), random);
    const double arc = std::pow(10, random.uniform(-4, 0.8)), size = std::pow(10, random.uniform(-6, 6));
    std::vector<Vec3> points = scenes::scan(truth, random.below(60), arc, random.below(2) ? 0.02 : 0, random).points;
    const auto squash = random.below(4);
    for (Vec3& q : points) {
      if (squash < 2) q.z() = 0;
      if (squash < 1) q.y() = 0;
      q *= size;
    }
    PrimitiveFitOptions options;
    options.robust = random.below(2) ? 2.5 : 0;
    const auto fit = fit_primitive(kind, points, {}, options);
    if (!fit) continue;
    INFO(name_of(kind) << " " << trial);
    CHECK(fit->primitive.point.allFinite());
    CHECK(fit->primitive.axis.norm() == Approx(1));
    for (const double value :
         {fit->primitive.radius, fit->primitive.tube, fit->primitive.half_angle, fit->rms, fit->sigma_radius,
          fit->sigma_tube, fit->sigma_half_angle, fit->sigma_point, fit->sigma_axis})
      CHECK((std::isfinite(value) && value >= 0));
  }
}
