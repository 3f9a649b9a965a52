// Rounded and chamfered edges, against the same part said without them.
#include "model/lower/edges.h"

#include <catch2/catch.hpp>

#include "core/random.h"
#include "model/check.h"
#include "model/distance/distance.h"
#include "testing/models.h"

using namespace partscribe::model;
using namespace partscribe::testing;

namespace {

Object object(const std::string& name, Shape shape, const Frame& frame = {}) {
  return {name, std::move(shape), frame, {}, {}};
}

Model of(std::vector<Object> objects) {
  Model m;
  m.objects = std::move(objects);
  return m;
}

/// The largest difference between two parts' distances near the first.
double apart(const Model& a, const Model& b, const Vec3& low, const Vec3& high) {
  const ModelDistance first(a), second(b);
  Random random(8);
  double worst = 0;
  for (int i = 0; i < 1500; ++i) {
    const Vec3 p(random.uniform(low.x(), high.x()), random.uniform(low.y(), high.y()),
                 random.uniform(low.z(), high.z()));
    worst = std::max(worst, std::abs(first(p).distance - second(p).distance));
  }
  return worst;
}

Model checked_or_fail(Model m) {
  auto outcome = check(m);
  if (const auto* c = std::get_if<Complaints>(&outcome)) FAIL(c->lines[0]);
  return m;
}

std::string fault(Model m) {
  auto outcome = check(std::move(m));
  const auto* c = std::get_if<Complaints>(&outcome);
  return c ? c->lines[0] : "";
}

}  // namespace

TEST_CASE("edges: every edge of a block is chamfered where it is, wherever the block stands") {
  const std::pair<const char*, const char*> edges[] = {{"block top", "block right"},    {"block right", "block back"},
                                                       {"block front", "block bottom"}, {"block left", "block top"},
                                                       {"block back", "block left"},    {"block bottom", "block back"}};
  for (const Frame& frame : {Frame{}, Frame{5, -2, 1, 0, 0, pi / 2}, Frame{1, 2, 3, pi / 2, 0, 0}}) {
    for (const auto& [a, b] : edges) {
      const Model m = checked_or_fail(
          of({object("block", Box{20, 14, 8}, frame), object("finished", EdgeChamfer{"block", a, b, 3, 2})}));
      // What is gone is a prism of half 3 times 2 on the edge: ask on both sides of its face.
      const ModelDistance whole(of({m.objects[0]})), part(m);
      Random random(4);
      double largest = 0, extra = 0;
      for (int i = 0; i < 4000; ++i) {
        const Box3 box = whole.bounds();
        const Vec3 p(random.uniform(box.low.x() - 1, box.high.x() + 1),
                     random.uniform(box.low.y() - 1, box.high.y() + 1),
                     random.uniform(box.low.z() - 1, box.high.z() + 1));
        const bool before = whole(p).distance < 0, after = part(p).distance < 0;
        if (before && !after) largest = std::max(largest, -whole(p).distance);
        extra += after && !before;
      }
      INFO(a << " and " << b);
      CHECK(extra == 0);
      CHECK(largest > 0.1);
      CHECK(largest < 1.21);  // where a circle touches both legs and the slope
    }
  }
}

TEST_CASE("edges: rounded, chamfered and filled edges are what the same profile gives") {
  // A block along y whose right upper edge is rounded.
  Loop profile = polygon({{0, 0}, {20, 0}});
  profile.elements.push_back(SketchArc{17, 5, 3, 0, pi / 2, "fillet", ""});
  profile.elements.push_back(SketchPoint{0, 8, ""});
  Model rounded = model_with(Extrude{{{profile}}, 14});
  rounded.objects[0].frame = {0, 14, 0, pi / 2, 0, 0};
  CHECK(apart(checked_or_fail(of({object("block", Box{20, 14, 8}),
                                  object("finished", EdgeFillet{"block", "block top", "block right", 3})})),
              rounded, {-5, -5, -5}, {25, 19, 13}) < 2e-4);
  // The inner edge of an angle, filled.
  Loop angle = polygon({{0, 0}, {20, 0}, {20, 4}});
  angle.elements.push_back(SketchArc{8, 8, 4, -pi / 2, -pi, "fillet", ""});
  angle.elements.push_back(SketchPoint{4, 20, ""});
  angle.elements.push_back(SketchPoint{0, 20, ""});
  Model filled = model_with(Extrude{{{angle}}, 10});
  filled.objects[0].frame = {0, 10, 0, pi / 2, 0, 0};
  CHECK(apart(checked_or_fail(of({object("foot", Box{20, 10, 4}), object("wall", Box{4, 10, 20}),
                                  object("both", Union{{"foot", "wall"}}),
                                  object("finished", EdgeFillet{"both", "foot top", "wall right", 4})})),
              filled, {-5, -5, -5}, {25, 15, 25}) < 2e-4);
  // A shaft with a shoulder: the shoulder filled, its outer edge chamfered.
  Loop shaft = polygon({{0, 0}, {12, 0}, {12, 8}, {10, 10}});
  shaft.elements.push_back(SketchArc{8, 13, 3, -pi / 2, -pi, "fillet", ""});
  shaft.elements.push_back(SketchPoint{5, 30, ""});
  shaft.elements.push_back(SketchPoint{0, 30, ""});
  CHECK(
      apart(checked_or_fail(of({object("thick", Cylinder{12, 10}), object("thin", Cylinder{5, 21}, {0, 0, 9, 0, 0, 0}),
                                object("blank", Union{{"thick", "thin"}}),
                                object("turned", EdgeFillet{"blank", "thick top", "thin side", 3}),
                                object("finished", EdgeChamfer{"turned", "thick side", "thick top", 2, 2})})),
            model_with(Revolve{{{shaft}}}), {-18, -18, -5}, {18, 18, 35}) < 2e-4);
}

TEST_CASE("edges: the mouth of a hole is chamfered like a countersink, in every direction") {
  for (const Frame& frame :
       {Frame{10, 7, 8, 0, 0, 0}, Frame{20, 7, 4, 0, pi / 2, 0}, Frame{10, 14, 4, -pi / 2, 0, 0}}) {
    const char* face = frame.ry == Expr(pi / 2)    ? "block right"
                       : frame.rx == Expr(-pi / 2) ? "block back"
                                                   : "block top";
    const Object block = object("block", Box{20, 14, 8});
    const Model worked = checked_or_fail(
        of({block, object("hole", Hole{4, 5, false}, frame), object("drilled", Difference{{"block", "hole"}}),
            object("finished", EdgeChamfer{"drilled", face, "hole wall", 1.5, 1.5})}));
    const Model sunk = of({block, object("hole", Hole{4, 5, false, 0, 0, 0, 7}, frame),
                           object("finished", Difference{{"block", "hole"}})});
    INFO(face);
    CHECK(apart(worked, sunk, {-5, -5, -5}, {25, 19, 13}) < 2e-4);
  }
}

TEST_CASE("edges: the tool follows the sizes that it hangs on") {
  Model m =
      of({object("block", Box{Expr::of("length"), 14, 8}),
          object("finished", EdgeChamfer{"block", "block top", "block right", Expr::of("leg"), Expr::of("leg")})});
  m.parameters = {length("length", 20), length("leg", 2)};
  const ModelDistance longer(checked_or_fail(m), {{"length", 30}, {"leg", 4}});
  CHECK(longer({28, 7, 6}).distance == Approx(0).margin(1e-9));
  CHECK(longer.faces()[static_cast<std::size_t>(longer({28, 7, 6}).face)].name == "finished chamfer");
}

TEST_CASE("edges: faces that do not make an edge are named in the complaint") {
  const Object block = object("block", Box{20, 14, 8}), hole = object("hole", Hole{4, 5, false}, {10, 7, 8, 0, 0, 0});
  const Object drilled = object("drilled", Difference{{"block", "hole"}});
  auto worked = [&](const char* a, const char* b) {
    return fault(of({block, hole, drilled, object("finished", EdgeFillet{"drilled", a, b, 1})}));
  };
  CHECK(worked("block top", "block lid").find("'block lid', found 0") != std::string::npos);
  CHECK(worked("block top", "block bottom").find("parallel") != std::string::npos);
  CHECK(worked("block front", "hole wall").find("right angle") != std::string::npos);
  CHECK(worked("block bottom", "hole wall").find("full circle") != std::string::npos);
  CHECK(worked("block top", "hole wall") == "");
}
