/// Every shape a model can hold.
#pragma once

#include <functional>
#include <string_view>
#include <variant>

#include "model/features.h"

namespace partscribe::model {

template <class N>
using ShapeOf = std::variant<BoxOf<N>, WedgeOf<N>, CylinderOf<N>, ConeOf<N>, SphereOf<N>, EllipsoidOf<N>, TorusOf<N>,
                             SuperellipsoidOf<N>, SupertoroidOf<N>, FilletOf<N>, HalfSpacesOf<N>, ExtrudeOf<N>,
                             RevolveOf<N>, TriSurfaceOf<N>, SurfaceSetOf<N>, UnionOf<N>, DifferenceOf<N>,
                             IntersectionOf<N>, HoleOf<N>, SlotOf<N>, PocketOf<N>, BossOf<N>, SweptSurfaceOf<N>,
                             LinearPatternOf<N>, CircularPatternOf<N>, MirrorOf<N>, EdgeFilletOf<N>, EdgeChamferOf<N>>;

using Box = BoxOf<Expr>;
using Wedge = WedgeOf<Expr>;
using Cylinder = CylinderOf<Expr>;
using Cone = ConeOf<Expr>;
using Sphere = SphereOf<Expr>;
using Ellipsoid = EllipsoidOf<Expr>;
using Torus = TorusOf<Expr>;
using Superellipsoid = SuperellipsoidOf<Expr>;
using Supertoroid = SupertoroidOf<Expr>;
using Fillet = FilletOf<Expr>;
using HalfSpace = HalfSpaceOf<Expr>;
using HalfSpaces = HalfSpacesOf<Expr>;
using Extrude = ExtrudeOf<Expr>;
using Revolve = RevolveOf<Expr>;
using TriSurface = TriSurfaceOf<Expr>;
using SurfaceSet = SurfaceSetOf<Expr>;
using Union = UnionOf<Expr>;
using Difference = DifferenceOf<Expr>;
using Intersection = IntersectionOf<Expr>;
using Hole = HoleOf<Expr>;
using Slot = SlotOf<Expr>;
using Pocket = PocketOf<Expr>;
using Boss = BossOf<Expr>;
using SweptSurface = SweptSurfaceOf<Expr>;
using LinearPattern = LinearPatternOf<Expr>;
using CircularPattern = CircularPatternOf<Expr>;
using Mirror = MirrorOf<Expr>;
using EdgeFillet = EdgeFilletOf<Expr>;
using EdgeChamfer = EdgeChamferOf<Expr>;
using SketchPoint = SketchPointOf<Expr>;
using SketchArc = SketchArcOf<Expr>;
using SketchNurbs = SketchNurbsOf<Expr>;
using SketchElement = SketchElementOf<Expr>;
using Loop = LoopOf<Expr>;
using Sketch = SketchOf<Expr>;
using Shape = ShapeOf<Expr>;
using EvaluatedSketch = SketchOf<double>;
using EvaluatedShape = ShapeOf<double>;

/// The name of a shape's kind: "cylinder".
template <class N>
std::string_view kind_of(const ShapeOf<N>& shape) {
  return std::visit([](const auto& s) { return std::remove_cvref_t<decltype(s)>::kind; }, shape);
}

/// An open triangulation or surface set: it has a front and bounds no solid.
bool is_sheet(const Shape& shape);

/// The same shape with every expression replaced by its value.
EvaluatedShape evaluate(const Shape& shape, const Values& values);
EvaluatedSketch evaluate(const Sketch& sketch, const Values& values);

/// Calls `visit` with every expression of the shape, in fields() order.
void visit_expressions(Shape& shape, const std::function<void(Expr&, Domain)>& visit);
void visit_expressions(const Shape& shape, const std::function<void(const Expr&, Domain)>& visit);

}  // namespace partscribe::model
