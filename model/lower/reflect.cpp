#include "model/lower/reflect.h"

#include <algorithm>

#include "core/ensure.h"
#include "core/number.h"
#include "model/lower/solids.h"
#include "model/overloaded.h"
#include "model/surface_patches.h"

namespace partscribe::model {
namespace {

using Renamed = std::function<std::string(const std::string&)>;

/// Half a turn about an axis.
Frame half_turn(int axis) {
  Frame f;
  (axis == 0 ? f.rx : axis == 1 ? f.ry : f.rz) = pi;
  return f;
}

Frame shifted(int axis, const Expr& by) {
  Frame f;
  (axis == 0 ? f.x : axis == 1 ? f.y : f.z) = by;
  return f;
}

/// A shape that is its own image behind every plane named in `own`, through its origin.
template <class S>
Placed symmetric(const S& s, int axis, std::initializer_list<int> own) {
  for (const int a : own)
    if (a == axis) return {s, {}};
  // Two reflections make half a turn about the third axis.
  return {s, half_turn(3 - axis - *own.begin())};
}

/// A shape that is its own image behind the plane in the middle of its height along z.
template <class S>
Placed symmetric_along_z(const S& s, int axis, const Expr& height) {
  if (axis == 2) return {s, shifted(2, -height)};
  Frame f = half_turn(1 - axis);  // turns z over as well
  f.z = height;
  return {s, f};
}

/// x becomes -x; loops run backwards, so that outlines stay counter-clockwise.
Loop reflected(const Loop& loop) {
  Loop result{loop.name, {}};
  const std::size_t count = loop.elements.size();
  auto edge_of = [](const SketchElement& e) { return std::visit([](const auto& x) { return x.edge; }, e); };
  for (std::size_t i = count; i-- > 0;) {
    SketchElement image = loop.elements[i];
    std::visit(Overloaded{[](SketchPoint& p) { p.x = -p.x; },
                          [](SketchArc& a) {
                            const Expr from = Expr(pi) - a.to, to = Expr(pi) - a.from;
                            a.center_x = -a.center_x, a.from = from, a.to = to;
                          },
                          [](SketchNurbs& n) {
                            for (auto& c : n.control) c[0] = -c[0];
                            std::reverse(n.control.begin(), n.control.end());
                            std::reverse(n.weights.begin(), n.weights.end());
                            std::reverse(n.knots.begin(), n.knots.end());
                            const double sum = n.knots.empty() ? 0 : n.knots.front() + n.knots.back();
                            for (double& k : n.knots) k = sum - k;
                          }},
               image);
    const std::string before = edge_of(loop.elements[(i + count - 1) % count]);
    std::visit([&](auto& e) { e.edge = before; }, image);
    result.elements.push_back(std::move(image));
  }
  return result;
}

Sketch reflected(const Sketch& sketch) {
  Sketch result;
  for (const auto& loop : sketch.loops) result.loops.push_back(reflected(loop));
  return result;
}

Placed over_sketch(Extrude s, int axis) {
  s.sketch = reflected(s.sketch);
  if (axis == 0) return {s, {}};
  return {s, half_turn(axis == 1 ? 2 : 1)};
}

template <class S>
Placed lowered_before(const S& s) {
  ensure(false, "worked edges are lowered before they are reflected");
  return {s, {}};
}

template <class S>
Placed combined(S s, const Renamed& renamed) {
  for (auto& name : s.objects) name = renamed(name);
  return {s, {}};
}

}  // namespace

Placed reflected(const Shape& shape, int axis, const Renamed& renamed) {
  return std::visit(Overloaded{
                        [&](const Box& s) -> Placed { return symmetric_along_z(s, axis, s.size_z); },
                        [&](const Wedge& s) -> Placed { return symmetric_along_z(s, axis, s.size_z); },
                        [&](const Cylinder& s) -> Placed {
                          return axis == 2 ? symmetric_along_z(s, axis, s.height) : symmetric(s, axis, {0, 1});
                        },
                        [&](const Cone& s) -> Placed {
                          return symmetric(s, axis, {0, 1});
                        },
                        [&](const Sphere& s) -> Placed {
                          return symmetric(s, axis, {0, 1, 2});
                        },
                        [&](const Ellipsoid& s) -> Placed {
                          return symmetric(s, axis, {0, 1, 2});
                        },
                        [&](const Torus& s) -> Placed {
                          return symmetric(s, axis, {0, 1, 2});
                        },
                        [&](Superellipsoid s) -> Placed {
                          // The bend lies in the x-z plane and is alike above and below z = 0.
                          if (axis != 1) s.bend = -s.bend;
                          return {s, axis == 2 ? half_turn(1) : Frame{}};
                        },
                        [&](const Supertoroid& s) -> Placed {
                          return symmetric(s, axis, {0, 1, 2});
                        },
                        [&](HalfSpaces s) -> Placed {
                          for (auto& p : s.planes) {
                            Expr& normal = axis == 0 ? p.normal_x : axis == 1 ? p.normal_y : p.normal_z;
                            normal = -normal;
                          }
                          return Placed{s, {}};
                        },
                        [&](const Extrude& s) -> Placed { return over_sketch(s, axis); },
                        [&](const Revolve& s) -> Placed {
                          if (s.angle == Expr(2 * pi)) return Placed{s, axis == 2 ? half_turn(0) : Frame{}};
                          // The image behind y = 0 runs from -angle to 0.
                          if (axis == 0) return Placed{s, {0, 0, 0, 0, 0, Expr(pi) - s.angle}};
                          if (axis == 1) return Placed{s, {0, 0, 0, 0, 0, -s.angle}};
                          return Placed{s, {0, 0, 0, pi, 0, s.angle}};
                        },
                        [&](TriSurface s) -> Placed {
                          for (auto& v : s.vertices)
                            v[static_cast<std::size_t>(axis)] = -v[static_cast<std::size_t>(axis)];
                          for (auto& t : s.triangles) std::swap(t[1], t[2]);
                          for (auto& face : s.faces)
                            for (auto* v : {&face.point, &face.axis})
                              if (!v->empty()) (*v)[static_cast<std::size_t>(axis)] *= -1;
                          return Placed{s, {}};
                        },
                        [&](SurfaceSet s) -> Placed {
                          for (auto& patch : s.patches) patch = mirrored(patch, axis);
                          return Placed{s, {}};
                        },
                        [&](const Union& s) -> Placed { return combined(s, renamed); },
                        [&](const Difference& s) -> Placed { return combined(s, renamed); },
                        [&](const Intersection& s) -> Placed { return combined(s, renamed); },
                        [&]<SaidSimpler S>(const S& s) -> Placed { return reflected(solid_of(s), axis, renamed); },
                        [&](LinearPattern s) -> Placed {
                          Expr& step = axis == 0 ? s.step_x : axis == 1 ? s.step_y : s.step_z;
                          step = -step, s.object = renamed(s.object);
                          return Placed{s, {}};
                        },
                        [&](CircularPattern s) -> Placed {
                          if (axis != 2) s.step = -s.step;
                          s.object = renamed(s.object);
                          return Placed{s, {}};
                        },
                        [&](Mirror s) -> Placed {
                          s.object = renamed(s.object);
                          if (s.axis == std::string(1, "xyz"[axis])) s.offset = -s.offset;
                          return {s, {}};
                        },
                        [&](const EdgeFillet& s) -> Placed { return lowered_before(s); },
                        [&](const EdgeChamfer& s) -> Placed { return lowered_before(s); },
                    },
                    shape);
}

Frame reflected(const Frame& f, int axis, const Expr& offset) {
  Frame r = f;
  Expr& along = axis == 0 ? r.x : axis == 1 ? r.y : r.z;
  along = Expr(2) * offset - along;
  if (axis != 0) r.rx = -r.rx;
  if (axis != 1) r.ry = -r.ry;
  if (axis != 2) r.rz = -r.rz;
  return r;
}

}  // namespace partscribe::model
