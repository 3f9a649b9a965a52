// The distance to a body with leaning walls, against points laid densely over its faces and against its sections.
#include "model/distance/drafted.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"
#include "model/check.h"
#include "model/distance/distance.h"
#include "testing/models.h"

using namespace partscribe::model;
using namespace partscribe::testing;

namespace {

/// A block with a round edge, a mitred notch and a bore.
Extrude cover(double height, double below, double draft) {
  const Loop outline{"outline",
                     {SketchPoint{0, 0, "front"}, SketchArc{26, 4, 4, -pi / 2, 0, "round", "right"},
                      SketchPoint{30, 18, "back"}, SketchPoint{18, 18, "cheek"}, SketchPoint{15, 12, "cheek 2"},
                      SketchPoint{12, 18, "back 2"}, SketchPoint{0, 18, "left"}}};
  const Loop bore{"bore", {SketchArc{9, 7, 3, 2 * pi, 0, "bore", ""}}};
  return {{{outline, bore}}, height, below, draft};
}

/// The section at a height, said anew: every straight edge of the cover as a half-plane moved by `t`.
bool in_section(double x, double y, double t) {
  if (x < t || x > 30 - t || y < t || y > 18 - t) return false;
  if (std::hypot(x - 9, y - 7) < 3 + t) return false;
  if (x > 26 && y < 4 && std::hypot(x - 26, y - 4) > 4 - t) return false;
  // The notch: below both of its cheeks is material.
  const double c = 6 / std::hypot(3, 6), s = 3 / std::hypot(3, 6);
  const bool above_right = -c * (x - 15) + s * (y - 12) > -t, above_left = c * (x - 15) + s * (y - 12) > -t;
  return !(above_right && above_left);
}

}  // namespace

TEST_CASE("drafted: inside is what the section at each height holds") {
  for (const double draft : {0.15, -0.12}) {
    const Model m = model_with(cover(9, 4, draft));
    REQUIRE(std::holds_alternative<CheckedModel>(check(m)));
    const ModelDistance distance(m);
    Random random(5);
    int within = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3 p(random.uniform(-3, 33), random.uniform(-3, 21), random.uniform(-6, 11));
      const bool inside = p.z() > -4 && p.z() < 9 && in_section(p.x(), p.y(), p.z() * std::tan(draft));
      within += inside;
      INFO(draft << ": " << p.transpose());
      CHECK((distance(p).distance < 0) == inside);
    }
    CHECK(within > 5000);
  }
}

TEST_CASE("drafted: the distance is that to the nearest of many points on the surface, and its foot lies there") {
  const Model m = model_with(cover(9, 4, 0.15));
  const auto solid = make_solid(evaluate(m.objects[0].shape, {}));
  REQUIRE(solid->faces.size() == 11);
  CHECK(solid->faces[1] == "round");
  CHECK(solid->faces[9] == "bottom");
  CHECK(solid->faces[10] == "top");
  Random random(6);
  // Every place on the surface is a foot of the places beside it.
  std::vector<Vec3> surface;
  for (int i = 0; i < 40000; ++i) {
    const Vec3 p(random.uniform(-2, 32), random.uniform(-2, 20), random.uniform(-6, 11));
    const LocalHit h = solid->hit(p);
    const Foot f = solid->foot(p, h.face);
    REQUIRE(f.distance == Approx(std::abs(h.distance)).margin(1e-12));
    REQUIRE((f.point - p).norm() == Approx(f.distance).margin(1e-12));
    REQUIRE(std::abs(solid->hit(f.point).distance) < 1e-9);
    surface.push_back(f.point);
  }
  for (int i = 0; i < 200; ++i) {
    const Vec3 p(random.uniform(-10, 40), random.uniform(-10, 30), random.uniform(-12, 20));
    double nearest = 1e300;
    for (const Vec3& q : surface) nearest = std::min(nearest, (p - q).norm());
    const double d = std::abs(solid->hit(p).distance);
    INFO(p.transpose());
    CHECK(d <= nearest + 1e-9);
    CHECK(d > nearest - 0.25);
  }
}

TEST_CASE("drafted: known distances from a frustum, and from a wall that leans by 45 degrees") {
  const Loop disc{"disc", {SketchArc{0, 0, 10, 0, 2 * pi, "side", ""}}};
  const Model frustum = model_with(Extrude{{{disc}}, 12, 0, std::atan2(5.0, 12.0)});
  const ModelDistance cone(frustum), same(model_with(Cone{10, 5, 12}));
  Random random(7);
  for (int i = 0; i < 500; ++i) {
    const Vec3 p(random.uniform(-15, 15), random.uniform(-15, 15), random.uniform(-5, 17));
    CHECK(cone(p).distance == Approx(same(p).distance).margin(1e-9));
  }
  const ModelDistance block(model_with(Extrude{{{polygon({{0, 0}, {40, 0}, {40, 30}, {0, 30}})}}, 10, 0, pi / 4}));
  CHECK(block({40, 15, 10}).distance == Approx(10 / std::sqrt(2.0)));
  CHECK(block({20, 15, 12}).distance == Approx(2));
  CHECK(block({20, 15, 4}).distance == Approx(-4));
  // Above the corner of the top.
  CHECK(block({31, 21, 13}).distance == Approx(Vec3(1, 1, 3).norm()));
}
