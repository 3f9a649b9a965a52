// A model said in fewer kinds of shapes is the same part.
#include "model/lower/lower.h"

#include <catch2/catch.hpp>

#include "core/random.h"
#include "model/check.h"
#include "model/distance/distance.h"
#include "testing/models.h"

using namespace partscribe::model;
using namespace partscribe::testing;

namespace {

/// Each model of one shape with a mirror behind its last object, which stands somewhere and turned.
Model mirrored(Model m, const std::string& axis, double offset) {
  m.objects.back().frame = {7, -3, 2, 0.3, -0.4, 0.9};
  const std::string name = m.objects.back().name;
  m.objects.push_back({"image", Mirror{name, axis, offset, false}, {}, {}, {}});
  return m;
}

Vec3 behind(Vec3 p, int axis, double offset) {
  p[axis] = 2 * offset - p[axis];
  return p;
}

}  // namespace

TEST_CASE("lower: the image of every shape is its image, behind each plane") {
  for (const Model& m : one_of_each()) {
    for (int axis = 0; axis < 3; ++axis) {
      const Model with_image = mirrored(m, std::string(1, "xyz"[axis]), 4);
      REQUIRE(std::holds_alternative<CheckedModel>(check(with_image)));
      Model without = with_image;
      without.objects.pop_back();
      const ModelDistance image(with_image), original(without);
      Random random(2);
      double worst = 0;
      for (int i = 0; i < 60; ++i) {
        const Vec3 p(random.uniform(-40, 40), random.uniform(-40, 40), random.uniform(-40, 40));
        worst = std::max(worst, std::abs(image(p).distance - original(behind(p, axis, 4)).distance));
      }
      INFO(kind_of(m.objects.back().shape) << " behind axis " << axis);
      CHECK(worst < 1e-4);
    }
  }
}

TEST_CASE("lower: what is left are basic shapes and the kinds that were asked for") {
  for (const Model& m : one_of_each()) {
    const Model basic = lowered(m, Kinds{});
    for (const Object& o : basic.objects) CHECK(std::visit([]<class S>(const S&) { return is_basic<S>; }, o.shape));
    CHECK(basic.objects.back().name == m.objects.back().name);
    CHECK(std::holds_alternative<CheckedModel>(check(basic)));
    const auto& shape = m.objects.back().shape;
    if (std::holds_alternative<EdgeFillet>(shape) || std::holds_alternative<EdgeChamfer>(shape)) continue;
    const Kinds its_own{kind_of(m.objects.back().shape)};
    CHECK(kind_of(lowered(m, its_own).objects.back().shape) == kind_of(m.objects.back().shape));
  }
}

TEST_CASE("lower: sizes stay expressions, so that what they mean can be edited") {
  const Model m =
      lowered(model_with(Hole{Expr::of("bore_d"), Expr::of("depth"), false}, {length("bore_d", 6), length("depth", 9)}),
              Kinds{});
  CHECK(std::get<Revolve>(m.objects[0].shape).sketch.loops[0].elements[1] ==
        SketchElement(SketchPoint{Expr::of("bore_d") / Expr(2), -Expr::of("depth"), "wall"}));
}

TEST_CASE("lower: islands become bodies of their own") {
  auto square = [](double half, bool backwards) {
    std::vector<std::pair<Expr, Expr>> corners = {{-half, -half}, {half, -half}, {half, half}, {-half, half}};
    if (backwards) std::reverse(corners.begin(), corners.end());
    return polygon(corners);
  };
  const Model m = model_with(Pocket{{{square(20, false), square(15, true), square(5, false)}}, 6});
  REQUIRE(std::holds_alternative<CheckedModel>(check(m)));
  const ModelDistance distance(m);
  CHECK(distance({17.5, 0, -3}).distance == Approx(-2.5));
  CHECK(distance({10, 0, -3}).distance == Approx(5));
  CHECK(distance({0, 0, -4}).distance == Approx(-2));
  CHECK(lowered(m, Kinds{}).objects.size() == 3);
}
