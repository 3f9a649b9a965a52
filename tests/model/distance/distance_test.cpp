// The exact distance to a model, against an independent way of getting it.
#include "model/distance/distance.h"

#include <catch2/catch.hpp>

#include "core/random.h"
#include "testing/models.h"

using namespace partscribe::model;
using namespace partscribe::testing;

namespace {

Vec3 near_body(Random& random, double reach = 40) {
  return {random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)};
}

}  // namespace

TEST_CASE("model distance: a step of the distance along the gradient lands on the surface") {
  // True of every exact distance outside the medial axis, whatever the shape.
  for (const auto& model : one_of_each()) {
    const ModelDistance distance(model);
    Random random(11);
    int good = 0, tried = 0;
    for (int i = 0; i < 300; ++i) {
      const Vec3 p = near_body(random);
      const double d = distance(p).distance, h = 1e-5;
      Vec3 g;
      for (int k = 0; k < 3; ++k)
        g[k] = (distance(p + h * Vec3::Unit(k)).distance - distance(p - h * Vec3::Unit(k)).distance) / (2 * h);
      if (std::abs(g.norm() - 1) > 1e-3) continue;  // on a ridge of the distance
      ++tried;
      good += std::abs(distance(p - d * g).distance) < 2e-3 * std::max(1.0, std::abs(d));
    }
    INFO(kind_of(model.objects[0].shape));
    CHECK(tried > 150);
    CHECK(good >= tried * 98 / 100);
  }
}

TEST_CASE("model distance: known points of the pin") {
  const ModelDistance distance(pin());
  CHECK(distance({0, 0, -3}).distance == Approx(3));
  CHECK(distance({25, 0, 12}).distance == Approx(5));
  CHECK(distance({0, 9 + 2, 40}).distance == Approx(2));
  CHECK(distance({0, 0, 30}).distance == Approx(-9));
  // On the round: 45 degrees below its centre circle.
  const double s = std::sqrt(0.5);
  CHECK(distance({10 + 10 * s + 1 * s, 0, 10 - 10 * s - 1 * s}).distance == Approx(1));
  const auto hit = distance({10 + 10 * s, 0, 10 - 10 * s});
  CHECK(std::abs(hit.distance) < 1e-12);
  CHECK(distance.faces()[static_cast<std::size_t>(hit.face)].name == "round");
}

TEST_CASE("model distance: the placement moves the part, and only when asked") {
  Model m = model_with(Sphere{5});
  m.scan_from_part = {100, 0, 0, 0, 0, 0};
  CHECK(ModelDistance(m)({107, 0, 0}).distance == Approx(2));
  m.as_scanned = false;
  CHECK(ModelDistance(m)({7, 0, 0}).distance == Approx(2));
}

TEST_CASE("model distance: an inside of the link is inside, its hole is not") {
  const ModelDistance distance(link());
  CHECK(distance({8, 0, 4}).distance < 0);
  CHECK(distance({0, 0, 4}).distance == Approx(5));
  CHECK(distance({20, 0, 4}).distance < 0);
  CHECK(distance({60, 0, 4}).distance == Approx(8));
  CHECK(distance({20, 15, 12}).distance == Approx(5));
}

TEST_CASE("model distance: a difference is cut where its tool is") {
  const auto models = one_of_each();
  const ModelDistance distance(models.back());
  CHECK(distance({10, 10, 10}).distance == Approx(4));
  CHECK(distance({3, 3, 10}).distance < 0);
  const auto hit = distance({10 + 3.9, 10, 10});
  CHECK(distance.faces()[static_cast<std::size_t>(hit.face)].object == "drill");
}

TEST_CASE("model distance: the sides of a sharp-edged fillet are told far from it and close to it") {
  for (const auto& [width, height] : {std::pair{14.0, 10.0}, {9.0, 9.0}}) {
    const ModelDistance distance(model_with(Fillet{width, height, 50}));
    Random random(3);
    for (int i = 0; i < 3000; ++i) {
      const double reach = i % 2 ? 3 * width : 1.2 * width;
      const double x = random.uniform(-reach, reach), y = random.uniform(-reach, reach);
      const double u = (x - width) / width, v = (y - height) / height;
      const bool inside = x > 0 && y > 0 && x < width && y < height && u * u + v * v > 1;
      INFO(x << ", " << y);
      CHECK((distance({x, y, 25}).distance < 0) == inside);
    }
  }
}
