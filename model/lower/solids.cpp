#include "model/lower/solids.h"

#include <algorithm>
#include <cmath>

#include "model/sketch.h"
#include "model/surface_patches.h"

namespace partscribe::model {
namespace {

Expr half(const Expr& e) { return e / Expr(2); }

/// How deep a cone of this whole angle is that narrows from one diameter to another.
Expr cone_depth(const Expr& wide, const Expr& narrow, const Expr& angle) {
  const Expr across = half(wide - narrow);
  if (angle == Expr(pi / 2)) return across;  // the usual countersink: tan(45 deg) is 1
  const Expr a = half(angle);
  return across * Expr::call(Expr::Kind::cos, {a}) / Expr::call(Expr::Kind::sin, {a});
}

bool zero(const Expr& e) { return e == Expr(0); }

}  // namespace

SurfaceSetOf<double> solid_of(const SweptSurfaceOf<double>& s) {
  return {swept(s.surface, Vec3(s.direction.data())), true, 0};
}
SurfaceSet solid_of(const SweptSurface& s) { return {swept(s.surface, Vec3(s.direction.data())), true, 0}; }

Extrude solid_of(const Fillet& s) {
  Loop loop{"outline", {SketchPoint{0, 0, "base"}}};
  if (s.width == s.height) {
    loop.elements.push_back(SketchArc{s.width, s.width, s.width, -pi / 2, -pi, "fillet", "wall"});
  } else {
    SketchNurbs curve;
    curve.degree = 2;
    curve.knots = {0, 0, 0, 1, 1, 1};
    curve.weights = {1, std::sqrt(0.5), 1};
    curve.control = {{{s.width, 0}}, {{0, 0}}, {{0, s.height}}};
    curve.name = "fillet", curve.edge = "wall";
    loop.elements.push_back(curve);
  }
  return {{{loop}}, s.length};
}

Revolve solid_of(const Hole& s) {
  const Expr radius = half(s.diameter);
  Loop loop{"hole", {}};
  auto corner = [&](const Expr& r, const Expr& z, const char* edge) {
    loop.elements.push_back(SketchPoint{r, z, edge});
  };
  // From the axis at the far end outwards, up the wall and back to the axis at the mouth.
  const Expr bottom = s.through ? -(s.depth + s.overshoot) : -s.depth;
  if (!s.through && !zero(s.tip_angle)) {
    corner(0, bottom - cone_depth(s.diameter, 0, s.tip_angle), "tip");
  } else {
    corner(0, bottom, s.through ? "far end" : "floor");
  }
  corner(radius, bottom, "wall");
  const bool head = !zero(s.head_diameter), sink = !zero(s.sink_diameter);
  const Expr head_radius = half(s.head_diameter), sink_radius = half(s.sink_diameter);
  const Expr floor = head ? -s.head_depth : Expr(0);
  if (sink) {
    corner(radius, floor - cone_depth(s.sink_diameter, s.diameter, s.sink_angle), "countersink");
    corner(sink_radius, floor, head ? "counterbore floor" : "rim");
  } else if (head) {
    corner(radius, floor, "counterbore floor");
  }
  if (head) corner(head_radius, floor, "counterbore");
  const Expr mouth = head ? head_radius : sink ? sink_radius : radius;
  corner(mouth, s.overshoot, "mouth");
  corner(0, s.overshoot, "axis");
  return {{{loop}}};
}

Extrude solid_of(const Slot& s) {
  const Expr reach = half(s.length - s.width), radius = half(s.width);
  const Loop loop{"slot",
                  {SketchArc{reach, 0, radius, -pi / 2, pi / 2, "end", "side"},
                   SketchArc{-reach, 0, radius, pi / 2, 3 * pi / 2, "end 2", "side 2"}}};
  return {{{loop}}, s.overshoot, s.through ? s.depth + s.overshoot : s.depth};
}

std::vector<Sketch> without_islands(const Sketch& sketch, const Values& values) {
  if (sketch.loops.size() < 2) return {sketch};
  const std::size_t count = sketch.loops.size();
  const auto around = loops_around(outline_of(evaluate(sketch, values)), count);
  std::vector<Sketch> result;
  std::size_t used = 0;
  for (std::size_t l = 0; l < count; ++l) {
    if (around[l].size() % 2) continue;
    Sketch one{{sketch.loops[l]}};
    for (std::size_t h = 0; h < count; ++h)
      if (around[h].size() == around[l].size() + 1 &&
          std::find(around[h].begin(), around[h].end(), l) != around[h].end())
        one.loops.push_back(sketch.loops[h]);
    used += one.loops.size();
    result.push_back(std::move(one));
  }
  // Loops that cross say nothing about what is inside what.
  return used == count ? result : std::vector<Sketch>{sketch};
}

}  // namespace partscribe::model
