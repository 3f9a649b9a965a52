// The distance to a tree of bodies, against the same part said as one shape, whose distance is exact.
#include <catch2/catch.hpp>

#include "core/random.h"
#include "model/distance/distance.h"
#include "testing/models.h"

using namespace partscribe::model;
using namespace partscribe::testing;

namespace {

Loop rectangle(const Expr& width, const Expr& depth) {
  return polygon({{0, 0}, {width, 0}, {width, depth}, {0, depth}});
}
Loop round_hole(double x, double y, double radius) {
  return {"hole", {SketchArc{x, y, radius, 2 * pi, 0, "hole", ""}}};
}
Object object(const std::string& name, Shape shape, const Frame& frame = {}) {
  return {name, std::move(shape), frame, {}, {}};
}
Model tree(std::vector<Object> objects, std::vector<Parameter> parameters = {}) {
  Model m;
  m.parameters = std::move(parameters);
  m.objects = std::move(objects);
  return m;
}

struct Twins {
  const char* name;
  Model tree, single;
  Vec3 low, high;
};

std::vector<Twins> twins() {
  std::vector<Twins> all;
  const Vec3 low(-6, -6, -6), high(46, 36, 16);
  {
    Sketch drilled{{rectangle(40, 30), round_hole(15, 12, 5)}};
    all.push_back({"a through hole",
                   tree({object("plate", Box{40, 30, 8}), object("hole", Hole{10, 8}, {15, 12, 8, 0, 0, 0}),
                         object("part", Difference{{"plate", "hole"}})}),
                   model_with(Extrude{drilled, 8}), low, high});
    drilled.loops.resize(1);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 2; ++j) drilled.loops.push_back(round_hole(8 + 12 * i, 8 + 14 * j, 3));
    all.push_back({"a grid of holes",
                   tree({object("plate", Box{40, 30, 8}), object("hole", Hole{6, 8}, {8, 8, 8, 0, 0, 0}),
                         object("row", LinearPattern{"hole", 3, 12, 0, 0}),
                         object("grid", LinearPattern{"row", Expr::of("rows"), 0, 14, 0}),
                         object("part", Difference{{"plate", "grid"}})},
                        {{"rows", Quantity::count, 2, 2}}),
                   model_with(Extrude{drilled, 8}), low, high});
  }
  const Loop ell = polygon({{0, 0}, {40, 0}, {40, 10}, {12, 10}, {12, 30}, {0, 30}});
  all.push_back({"bodies that touch",
                 tree({object("foot", Box{40, 10, 8}), object("wall", Box{12, 20, 8}, {0, 10, 0, 0, 0, 0}),
                       object("part", Union{{"foot", "wall"}})}),
                 model_with(Extrude{{{ell}}, 8}), low, high});
  all.push_back(
      {"bodies that overlap and have faces in common",
       tree({object("foot", Box{40, 10, 8}), object("wall", Box{12, 30, 8}), object("part", Union{{"foot", "wall"}})}),
       model_with(Extrude{{{ell}}, 8}), low, high});
  all.push_back({"a shaft of touching cylinders",
                 tree({object("thick", Cylinder{12, 10}), object("thin", Cylinder{5, 20}, {0, 0, 10, 0, 0, 0}),
                       object("part", Union{{"thick", "thin"}})}),
                 model_with(Revolve{{{polygon({{0, 0}, {12, 0}, {12, 10}, {5, 10}, {5, 30}, {0, 30}})}}}),
                 Vec3(-18, -18, -6), Vec3(18, 18, 36)});
  all.push_back({"a boss whose root reaches into the body",
                 tree({object("thick", Cylinder{12, 10}),
                       object("thin", Boss{{{{"round", {SketchArc{0, 0, 5, 0, 2 * pi, "round", ""}}}}}, 20, 4},
                              {0, 0, 10, 0, 0, 0}),
                       object("part", Union{{"thick", "thin"}})}),
                 model_with(Revolve{{{polygon({{0, 0}, {12, 0}, {12, 10}, {5, 10}, {5, 30}, {0, 30}})}}}),
                 Vec3(-18, -18, -6), Vec3(18, 18, 36)});
  all.push_back(
      {"a corner of three bodies",
       tree({object("a", Box{40, 90, 90}, {0, -30, -30, 0, 0, 0}), object("b", Box{90, 30, 90}, {-30, 0, -30, 0, 0, 0}),
             object("c", Box{90, 90, 8}, {-30, -30, 0, 0, 0, 0}), object("part", Intersection{{"a", "b", "c"}})}),
       model_with(Box{40, 30, 8}), low, high});
  all.push_back({"a notch in an edge",
                 tree({object("plate", Box{40, 30, 8}), object("cutter", Box{12, 20, 20}, {10, 18, -5, 0, 0, 0}),
                       object("part", Difference{{"plate", "cutter"}})}),
                 model_with(Extrude{
                     {{polygon({{0, 0}, {40, 0}, {40, 30}, {22, 30}, {22, 18}, {10, 18}, {10, 30}, {0, 30}})}}, 8}),
                 low, high});
  {
    Loop lug = polygon({{20, 0}, {40, 0}, {40, 30}, {25, 12}});
    Loop image = polygon({{0, 0}, {20, 0}, {15, 12}, {0, 30}});
    Sketch both{{polygon({{0, 0}, {40, 0}, {40, 30}, {25, 12}, {15, 12}, {0, 30}})}};
    all.push_back({"a body and its image, with a band between them",
                   tree({object("lug", Extrude{{{lug}}, 8}), object("both", Mirror{"lug", "x", 20, true}),
                         object("band", Box{20, 12, 8}, {10, 0, 0, 0, 0, 0}), object("part", Union{{"both", "band"}})}),
                   model_with(Extrude{both, 8}), low, high});
  }
  return all;
}

}  // namespace

TEST_CASE("tree distance: what several bodies leave is measured as the one shape that it is") {
  for (const auto& [name, tree, single, low, high] : twins()) {
    const ModelDistance measured(tree), exact(single);
    Random random(5);
    double worst = 0;
    Vec3 place = low;
    int wrong_side = 0;
    for (int i = 0; i < 3000; ++i) {
      const Vec3 p(random.uniform(low.x(), high.x()), random.uniform(low.y(), high.y()),
                   random.uniform(low.z(), high.z()));
      const double d = measured(p).distance, e = exact(p).distance;
      if (std::abs(d - e) > worst) worst = std::abs(d - e), place = p;
      wrong_side += (d < 0) != (e < 0);
    }
    INFO(name << ": " << place.transpose() << ": " << measured(place).distance << " for " << exact(place).distance);
    CHECK(worst < 2e-4);
    CHECK(wrong_side == 0);
  }
}

TEST_CASE("tree distance: faces inside other bodies, and where bodies touch, are no surface") {
  const Model m = twins()[2].tree;
  const ModelDistance distance(m);
  CHECK(distance({6, 10, 4}).distance == Approx(-4));  // on the face that both boxes have in common
  CHECK(distance({6, 9.5, 4}).distance == Approx(-4));
}

TEST_CASE("tree distance: each copy in a pattern has faces of its own, named by pattern and number") {
  const Model m = twins()[1].tree;
  const ModelDistance distance(m);
  const auto face_at = [&](const Vec3& p) { return distance.faces()[static_cast<std::size_t>(distance(p).face)]; };
  CHECK(face_at({8 + 2.9, 8, 4}).name == "grid 1 wall");
  CHECK(face_at({32 + 2.9, 8, 4}).name == "grid 3 wall");
  CHECK(face_at({8 + 2.9, 22, 4}).name == "grid 4 wall");
  CHECK(face_at({32 + 2.9, 22, 4}).object == "hole");
  CHECK(face_at({32 + 2.9, 22, 4}).feature == "grid 6");
  CHECK(face_at({20, 15, 7.9}).name == "plate top");
}

TEST_CASE("tree distance: solids that a parameter does not change are not built again, and the answer is the same") {
  const Model m =
      tree({object("plate", Box{Expr::of("width"), 30, 8}), object("hole", Hole{10, 8}, {15, 12, 8, 0, 0, 0}),
            object("part", Difference{{"plate", "hole"}})},
           {length("width", 40)});
  const ModelDistance before(m), other(m, {{"width", 44}}), stepped(m, {{"width", 44}}, &before);
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Vec3 p(random.uniform(-5, 50), random.uniform(-5, 35), random.uniform(-5, 12));
    CHECK(stepped(p).distance == other(p).distance);
  }
  CHECK(stepped({42, 15, 4}).distance == Approx(-2));
}

TEST_CASE("tree distance: part of a turn ends at two plane faces") {
  const Loop ring = polygon({{5, 0}, {10, 0}, {10, 4}, {5, 4}});
  const ModelDistance quarter(model_with(Revolve{{{ring}}, pi / 2}));
  CHECK(quarter({7, -2, 2}).distance == Approx(2));  // before the start
  CHECK(quarter({-3, 7, 2}).distance == Approx(3));  // beyond the end
  CHECK(quarter({12 * std::sqrt(0.5), 12 * std::sqrt(0.5), 2}).distance == Approx(2));
  CHECK(quarter({7, 1, 2}).distance == Approx(-1));
  CHECK(quarter.faces()[static_cast<std::size_t>(quarter({7, 1, 2}).face)].name == "start");
  const ModelDistance most(model_with(Revolve{{{ring}}, 1.5 * pi}));
  CHECK(most({7, -7, 2}).distance == Approx(7));
  CHECK(most({-7, -1, 2}).distance < 0);
}
