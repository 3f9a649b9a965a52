#include "geometry/images/grid_normals.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/statistics.h"
#include "testing/range_scenes.h"

using namespace partscribe::geometry;
using namespace partscribe::testing;

namespace {

constexpr double degree = 3.14159265358979 / 180;
const double nothing = std::nan("");

double angle(const Eigen::Vector3f& single, const Vec3& b) {
  const Vec3 a = single.cast<double>();
  return std::atan2(a.cross(b).norm(), a.dot(b)) / degree;
}

/// Against the truth of every pixel that has one; 180 where there is no normal.
std::vector<double> errors(const RangeScene& scene, const std::function<Vec3(double, double)>& truth) {
  const auto normals = grid_normals(scene.image, {}, 1);
  std::vector<double> result;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (std::isnan(scene.truth[i])) continue;
    const double c = static_cast<double>(i % static_cast<std::size_t>(scene.image.width)),
                 r = static_cast<double>(i / static_cast<std::size_t>(scene.image.width));
    result.push_back(normals[i].isZero() ? 180 : angle(normals[i], truth(c, r)));
  }
  return result;
}

double share_below(const std::vector<double>& values, double limit) {
  return static_cast<double>(std::count_if(values.begin(), values.end(), [&](double v) { return v < limit; })) /
         static_cast<double>(values.size());
}

double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace

TEST_CASE("grid normals: on a plane the error is that of a plane through 25 points") {
  for (const double slope : {0.0, 0.5, 2.0})
    for (const double sigma : {0.01, 0.05}) {
      RangeSceneOptions o;
      o.sigma = sigma;
      const RangeScene scene = range_scene(o, [&](double c, double) { return 10 + slope * c * 0.5; });
      const Vec3 truth = Vec3(slope * 0.5, 0, -1).normalized();
      std::vector<double> inside;
      const auto normals = grid_normals(scene.image, {}, 1);
      for (int r = 2; r < o.height - 2; ++r)
        for (int c = 2; c < o.width - 2; ++c)
          inside.push_back(angle(normals[static_cast<std::size_t>(r * o.width + c)], truth));
      INFO("slope " << slope << ", sigma " << sigma);
      // Two slopes, each with sigma / 7.07; tilted, they turn the normal less.
      const double cosine = -truth.z();
      const double limit = sigma / 7.0711 * std::sqrt(std::pow(cosine, 4) + std::pow(cosine, 2)) / degree;
      CHECK(rms(inside) < 1.1 * limit);
      CHECK(rms(inside) > 0.9 * limit);
    }
}

TEST_CASE("grid normals: without noise they are a plane's, also at the borders of the image") {
  RangeSceneOptions o;
  o.sigma = 0, o.q = 1.0 / 512;
  const RangeScene scene = range_scene(o, [](double c, double r) { return 30 + 0.25 * c - 0.25 * r; });
  for (const double e : errors(scene, [](double, double) { return Vec3(0.25, -0.25, -1).normalized(); }))
    REQUIRE(e < 1e-3);
}

TEST_CASE("grid normals: a crease stays sharp up to the pixels beside it") {
  RangeSceneOptions o;
  o.sigma = 0.01;
  for (const double turn : {0.0, 0.37, 1.0}) {  // of the crease against the columns
    const auto side = [&](double c, double r) { return (c - 39.5) + turn * (r - 29.5); };
    const RangeScene scene = range_scene(o, [&](double c, double r) { return 40 - 0.4 * std::abs(side(c, r)); });
    const auto off = errors(scene, [&](double c, double r) {
      const double slope = side(c, r) < 0 ? 0.4 : -0.4;
      return Vec3(slope, slope * turn, -1).normalized();
    });
    INFO("turn " << turn);
    CHECK(share_below(off, 3) > 0.99);
  }
}

TEST_CASE("grid normals: samples beyond a step or a hole have no part in a normal") {
  RangeSceneOptions o;
  o.sigma = 0.01;
  const auto hole = [](double c, double r) { return std::hypot(c - 60, r - 40) < 6.3 || (c > 8 && c < 11 && r < 20); };
  const RangeScene scene = range_scene(o, [&](double c, double r) {
    return hole(c, r) ? nothing : c < 30 ? 20 : r < 25.5 ? 23 : 20.5;
  });
  const auto normals = grid_normals(scene.image, {}, 1);
  for (std::size_t i = 0; i < normals.size(); ++i) REQUIRE(normals[i].isZero() == std::isnan(scene.truth[i]));
  const auto off = errors(scene, [](double, double) { return Vec3(0, 0, -1); });
  CHECK(share_below(off, 0.5) > 0.98);
  CHECK(share_below(off, 2) == 1);
}

TEST_CASE("grid normals: a flipped bit spoils neither its neighbours' normals nor its own") {
  RangeSceneOptions o;
  o.sigma = 0.01, o.bit_error = 0.02, o.width = 160, o.height = 120;
  const RangeScene scene = range_scene(o, [](double c, double r) { return 10 + 0.3 * c + 0.2 * r; });
  const auto off = errors(scene, [](double, double) { return Vec3(0.3, 0.2, -1).normalized(); });
  CHECK(share_below(off, 0.5) > 0.995);
  CHECK(share_below(off, 5) > 0.9995);
}

TEST_CASE("grid normals: a bent surface is not taken for edges") {
  RangeSceneOptions o;
  o.sigma = 0.002, o.q = 0.001;
  const double radius = 60;
  const auto height = [&](double c, double r) {
    return 70 - std::sqrt(radius * radius - std::pow(c - 40, 2) - std::pow(r - 30, 2));
  };
  const RangeScene scene = range_scene(o, height);
  const auto normals = grid_normals(scene.image, {}, 1);
  std::vector<double> off;
  for (int r = 2; r < o.height - 2; ++r)
    for (int c = 2; c < o.width - 2; ++c)
      off.push_back(angle(normals[static_cast<std::size_t>(r * o.width + c)],
                          -Vec3(40 - c, 30 - r, 70 - height(c, r)).normalized()));
  // A shifted window would be off by two pixels, 1.9 degrees.
  CHECK(share_below(off, 0.3) > 0.98);
  CHECK(median(off) < 0.1);
}

TEST_CASE("grid normals: behind a pinhole a plane has one normal wherever it is seen") {
  RangeImage image;
  image.projection = Projection::pinhole;
  image.width = 90, image.height = 70, image.fx = image.fy = 100, image.cx = 44, image.cy = 36, image.z0 = 0,
  image.q = 0.002;
  const Vec3 truth = Vec3(0.3, -0.2, -1).normalized();
  Random random(3);
  for (int r = 0; r < image.height; ++r)
    for (int c = 0; c < image.width; ++c) {
      const Vec3 ray((c - image.cx) / image.fx, (r - image.cy) / image.fy, 1);
      const double z = truth.dot(Vec3(0, 0, 50)) / truth.dot(ray) + 0.005 * random.normal();
      image.codes.push_back(static_cast<std::uint16_t>(std::lround(1 + z / image.q)));
    }
  const auto normals = grid_normals(image, {}, 1);
  for (const Eigen::Vector3f& n : normals) REQUIRE(angle(n, truth) < 1.5);
}

TEST_CASE("grid normals: images of one pixel, one row or nothing do no harm") {
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 7}, {40, 1}, {3, 3}, {17, 2}, {0, 0}})
    for (const int code : {0, 500}) {
      RangeImage image;
      image.width = width, image.height = height;
      image.codes.assign(static_cast<std::size_t>(width * height), static_cast<std::uint16_t>(code));
      const auto normals = grid_normals(image, {}, 1);
      REQUIRE(normals.size() == image.codes.size());
      // A plane needs two rows, two columns and six pixels.
      const bool any = code > 0 && width > 1 && height > 1;
      for (const Eigen::Vector3f& n : normals) CHECK(n == Eigen::Vector3f(0, 0, any ? -1.F : 0.F));
    }
}

TEST_CASE("grid normals: the number of threads and the mirror change nothing") {
  RangeSceneOptions o;
  o.sigma = 0.02, o.bit_error = 0.01, o.width = 203, o.height = 151;
  const RangeScene scene = range_scene(o, [](double c, double r) {
    return std::hypot(c - 90, r - 70) > 65 ? nothing
                                           : 30 + 0.2 * c + (r > 80 ? 5 : 0) + 0.01 * std::pow(r - 40, 2) * (c > 100);
  });
  const auto one = grid_normals(scene.image, {}, 1), three = grid_normals(scene.image, {}, 3);
  for (std::size_t i = 0; i < one.size(); ++i) REQUIRE(one[i] == three[i]);
  RangeImage mirror = scene.image;
  for (int r = 0; r < o.height; ++r)
    for (int c = 0; c < o.width; ++c)
      mirror.codes[static_cast<std::size_t>(r * o.width + c)] =
          scene.image.codes[static_cast<std::size_t>(r * o.width + o.width - 1 - c)];
  const auto back = grid_normals(mirror, {.sigma = 0.02}, 1), straight = grid_normals(scene.image, {.sigma = 0.02}, 1);
  std::size_t differ = 0, known = 0;
  for (int r = 0; r < o.height; ++r)
    for (int c = 0; c < o.width; ++c) {
      const Eigen::Vector3f &a = straight[static_cast<std::size_t>(r * o.width + c)],
                            &b = back[static_cast<std::size_t>(r * o.width + o.width - 1 - c)];
      known += !a.isZero();
      differ += (a - Eigen::Vector3f(-b.x(), b.y(), b.z())).norm() > 1e-3;
    }
  CHECK(known > 10000);
  CHECK(differ < known / 500);  // windows that are equally good
}
