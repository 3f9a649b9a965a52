#include "geometry/normals/characterize.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "geometry/normals/normals.h"
#include "testing/range_scenes.h"

using namespace partscribe::geometry;
using namespace partscribe::testing;

namespace {

std::vector<CharacterizedPoint> characterized(const RangeScene& s, double radius = 0) {
  Context context;
  const auto filtered = rlts_filter(s.image, {}, context);
  return characterize(surface_graph(s.image, filtered, {}), {.radius = radius}, context);
}

double share(const std::vector<CharacterizedPoint>& points, SurfaceClass kind) {
  double count = 0, known = 0;
  for (const auto& p : points) known += p.kind != SurfaceClass::unknown, count += p.kind == kind;
  return known > 0 ? count / known : 0;
}

template <class Value>
double middle(const std::vector<CharacterizedPoint>& points, const Value& value) {
  std::vector<double> values;
  for (const auto& p : points)
    if (p.kind != SurfaceClass::unknown) values.push_back(value(p));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// Quadratic depth with the given second derivatives; the sensor looks along +z, so a bulge towards it has xx > 0.
RangeScene bowl(double xx, double xy, double yy, double sigma = 0.01) {
  return range_scene({.sigma = sigma}, [=](double x, double y) {
    const double u = x - 40, v = y - 30;
    return 60 + 0.5 * (xx * u * u + 2 * xy * u * v + yy * v * v);
  });
}

}  // namespace

TEST_CASE("characterize: the signs of the eight classes are found on images") {
  CHECK(share(characterized(bowl(0.02, 0, 0.02)), SurfaceClass::peak) > 0.95);
  CHECK(share(characterized(bowl(-0.02, 0, -0.02)), SurfaceClass::pit) > 0.95);
  CHECK(share(characterized(bowl(0.02, 0, 0)), SurfaceClass::ridge) > 0.95);
  CHECK(share(characterized(bowl(0, 0, -0.02)), SurfaceClass::valley) > 0.95);
  CHECK(share(characterized(bowl(0.03, 0, -0.012)), SurfaceClass::saddle_ridge) > 0.8);
  CHECK(share(characterized(bowl(-0.03, 0, 0.012)), SurfaceClass::saddle_valley) > 0.8);
  CHECK(share(characterized(bowl(0, 0, 0)), SurfaceClass::flat) > 0.98);
  CHECK(share(characterized(range_scene({.width = 31, .height = 31, .sigma = 0.01},
                                        [](double x, double y) { return 60 + 0.02 * (x - 15) * (y - 15); })),
              SurfaceClass::minimal) > 0.4);  // exactly minimal along its axes only
  CHECK(share(characterized(bowl(0.004, 0, 0.004, 0.5)), SurfaceClass::flat) > 0.95);  // hidden in noise
}

TEST_CASE("characterize: curvatures of a sphere and a cylinder, with the noise that is stated") {
  const auto ball = range_scene({.sigma = 0.02}, [](double x, double y) {
    return 100 - std::sqrt(std::max(50 * 50 - (x - 40) * (x - 40) - (y - 30) * (y - 30), 0.0));
  });
  const auto points = characterized(ball);
  CHECK(middle(points, [](const CharacterizedPoint& p) { return p.mean; }) == Approx(-0.02).epsilon(0.05));
  CHECK(middle(points, [](const CharacterizedPoint& p) { return p.gaussian; }) == Approx(0.0004).epsilon(0.1));
  double pull = 0;
  int count = 0;
  for (int r = 15; r < 45; ++r)
    for (int c = 20; c < 60; ++c) {
      const auto& p = points[static_cast<std::size_t>(r * 80 + c)];
      if (p.kind == SurfaceClass::unknown) continue;
      const double u = (p.mean + 0.02) / p.sigma_mean;
      pull += u * u, ++count;
    }
  CHECK(std::sqrt(pull / count) < 1.5);
  CHECK(std::sqrt(pull / count) > 0.6);
  const auto bar = characterized(
      range_scene({.sigma = 0.01}, [](double, double y) { return 100 - std::sqrt(40 * 40 - (y - 30) * (y - 30)); }));
  CHECK(middle(bar, [](const CharacterizedPoint& p) { return p.least; }) == Approx(-0.025).epsilon(0.05));
  CHECK(middle(bar, [](const CharacterizedPoint& p) { return std::abs(p.along_least.y()); }) > 0.8);
  CHECK(middle(bar, [](const CharacterizedPoint& p) { return std::abs(p.most); }) < 0.002);
}

TEST_CASE("characterize: next to steps and creases a plane stays flat") {
  const auto step = characterized(range_scene({}, [](double x, double y) { return 30 + (x < 40 ? 0 : 8) + 0.1 * y; }));
  CHECK(share(step, SurfaceClass::flat) > 0.97);
  const auto roof = characterized(range_scene({}, [](double x, double) { return 60 - 0.8 * std::abs(x - 40.4); }));
  CHECK(share(roof, SurfaceClass::flat) > 0.97);
}

TEST_CASE("characterize: a cloud says the same as an image") {
  Random random(8);
  Context context;
  PointCloud cloud;
  for (int i = 0; i < 9000; ++i) {
    const Vec3 d = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    cloud.points.push_back((20 + 0.01 * random.normal()) * d), cloud.rays.push_back(-d);
  }
  estimate_normals(cloud, {}, context);
  const auto outside = characterize(surface_graph(cloud, {}, context), {}, context);
  CHECK(share(outside, SurfaceClass::peak) > 0.9);
  CHECK(middle(outside, [](const CharacterizedPoint& p) { return p.mean; }) == Approx(-0.05).epsilon(0.05));
  for (Vec3& n : cloud.normals) n = -n;  // a hole of the same radius
  CHECK(share(characterize(surface_graph(cloud, {}, context), {}, context), SurfaceClass::pit) > 0.9);
}

TEST_CASE("characterize: a motion of the cloud changes no curvature, and a scale divides it") {
  Random random(9);
  Context context;
  PointCloud cloud;
  for (int i = 0; i < 3000; ++i) {
    const double x = random.uniform(-10, 10), y = random.uniform(-10, 10);
    cloud.points.push_back({x, y, 0.03 * x * x - 0.02 * y * y + 0.002 * random.normal()});
    cloud.normals.push_back(Vec3(-0.06 * x, 0.04 * y, 1).normalized()), cloud.sigma.push_back(0.002F);
  }
  const auto before = characterize(surface_graph(cloud, {}, context), {.radius = 2}, context);
  const Mat3 turn = rotation_of(Vec3(0.3, -0.8, 0.5));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.points[i] = 3 * (turn * cloud.points[i]) + Vec3(50, -20, 10);
    cloud.normals[i] = turn * cloud.normals[i], cloud.sigma[i] *= 3;
  }
  const auto after = characterize(surface_graph(cloud, {}, context), {.radius = 6}, context);
  int same = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    CHECK(3 * after[i].mean == Approx(before[i].mean).margin(1e-6));
    CHECK(9 * after[i].gaussian == Approx(before[i].gaussian).margin(1e-6));
    same += before[i].kind == after[i].kind;
  }
  CHECK(same >= 2998);
}

TEST_CASE("characterize: bad input has answers too") {
  Context context;
  CHECK(characterize(surface_graph(PointCloud{}, {}, context), {}, context).empty());
  PointCloud one;
  one.points.assign(1, Vec3::Zero()), one.normals.assign(1, Vec3::UnitZ()), one.sigma.assign(1, 0.1F);
  CHECK(characterize(surface_graph(one, {}, context), {}, context)[0].kind == SurfaceClass::unknown);
  PointCloud line;
  for (int i = 0; i < 100; ++i)
    line.points.push_back({0.1 * i, 0, 0}), line.normals.push_back(Vec3::UnitZ()), line.sigma.push_back(0);
  for (const auto& p : characterize(surface_graph(line, {}, context), {}, context))
    CHECK(p.kind == SurfaceClass::unknown);
  const double none = std::numeric_limits<double>::quiet_NaN();
  const auto nothing = range_scene({}, [&](double, double) { return none; });
  for (const auto& p : characterized(nothing)) CHECK(p.kind == SurfaceClass::unknown);
}
