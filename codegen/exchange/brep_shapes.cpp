#include "codegen/exchange/brep_shapes.h"

#include <BRepAdaptor_Surface.hxx>
#include <BRepBuilderAPI_GTransform.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepGProp.hxx>
#include <BRepLib.hxx>
#include <BRepOffsetAPI_DraftAngle.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRepPrimAPI_MakeWedge.hxx>
#include <BRep_Builder.hxx>
#include <GProp_GProps.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_Circle.hxx>
#include <Geom_Line.hxx>
#include <Geom_Plane.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <cmath>
#include <gp_Circ.hxx>
#include <gp_GTrsf.hxx>
#include <gp_Pln.hxx>
#include <tuple>

#include "core/number.h"
#include "geometry/mesh/convex.h"
#include "model/sketch.h"

namespace partscribe::codegen {
namespace {

/// The plane in which a sketch is drawn.
struct SketchPlane {
  gp_Ax3 frame;
  gp_Pnt at(const Vec2& p) const {
    return frame.Location().Translated(gp_Vec(frame.XDirection()) * p.x() + gp_Vec(frame.YDirection()) * p.y());
  }
};

TopoDS_Vertex vertex_between(const Vec2& end, const Vec2& start, const SketchPlane& plane) {
  TopoDS_Vertex vertex;
  BRep_Builder().MakeVertex(vertex, plane.at(start), std::max(1e-7, 1.1 * (end - start).norm()));
  return vertex;
}

TopoDS_Edge edge_of(const Line2& line, const TopoDS_Vertex& a, const TopoDS_Vertex& b, const SketchPlane& plane) {
  const gp_Vec along(plane.at(line.a), plane.at(line.b));
  return BRepBuilderAPI_MakeEdge(new Geom_Line(plane.at(line.a), gp_Dir(along)), a, b, 0.0, along.Magnitude());
}

TopoDS_Edge edge_of(const Arc2& arc, const TopoDS_Vertex& a, const TopoDS_Vertex& b, const SketchPlane& plane) {
  // A clockwise arc runs counter-clockwise about the opposite axis.
  const bool clockwise = arc.to < arc.from;
  const gp_Dir axis = clockwise ? plane.frame.Direction().Reversed() : plane.frame.Direction();
  const gp_Circ circle(gp_Ax2(plane.at(arc.center), axis, plane.frame.XDirection()), arc.radius);
  const double from = clockwise ? -arc.from : arc.from, to = clockwise ? -arc.to : arc.to;
  if (to - from > 2 * pi - 1e-9) {
    gp_Circ whole(circle);
    whole.Rotate(circle.Axis(), from);
    return BRepBuilderAPI_MakeEdge(whole, a, a);
  }
  return BRepBuilderAPI_MakeEdge(new Geom_Circle(circle), a, b, from, to);
}

TopoDS_Edge edge_of(const Nurbs2& curve, const TopoDS_Vertex& a, const TopoDS_Vertex& b, const SketchPlane& plane) {
  const int count = static_cast<int>(curve.points.size());
  TColgp_Array1OfPnt poles(1, count);
  TColStd_Array1OfReal weights(1, count);
  for (int i = 0; i < count; ++i) {
    poles(i + 1) = plane.at(curve.points[static_cast<std::size_t>(i)]);
    weights(i + 1) = curve.weights.empty() ? 1 : curve.weights[static_cast<std::size_t>(i)];
  }
  const auto distinct = curve.t.multiplicities();
  TColStd_Array1OfReal knots(1, static_cast<int>(distinct.size()));
  TColStd_Array1OfInteger multiplicities(1, static_cast<int>(distinct.size()));
  for (std::size_t i = 0; i < distinct.size(); ++i)
    std::tie(knots(static_cast<int>(i) + 1), multiplicities(static_cast<int>(i) + 1)) = distinct[i];
  const Handle(Geom_BSplineCurve) spline =
      curve.weights.empty() ? new Geom_BSplineCurve(poles, knots, multiplicities, curve.t.degree)
                            : new Geom_BSplineCurve(poles, weights, knots, multiplicities, curve.t.degree);
  return BRepBuilderAPI_MakeEdge(spline, a, b, curve.t.low(), curve.t.high());
}

TopoDS_Face face_of(const EvaluatedSketch& sketch, const SketchPlane& plane) {
  const Outline2 outline = outline_of(sketch);
  const int loops = static_cast<int>(sketch.loops.size());
  TopoDS_Face face;
  BRep_Builder builder;
  builder.MakeFace(face, new Geom_Plane(plane.frame), 1e-7);
  for (int loop = 0; loop < loops; ++loop) {
    std::vector<const Curve2*> curves;
    for (const auto& c : outline.curves) {
      if (c.loop == loop) curves.push_back(&c.curve);
    }
    const std::size_t count = curves.size();
    std::vector<TopoDS_Vertex> starts;
    for (std::size_t i = 0; i < count; ++i) {
      starts.push_back(vertex_between(end_of(*curves[(i + count - 1) % count]), start_of(*curves[i]), plane));
    }
    TopoDS_Wire wire;
    builder.MakeWire(wire);
    for (std::size_t i = 0; i < count; ++i) {
      const TopoDS_Edge edge =
          std::visit([&](const auto& c) { return edge_of(c, starts[i], starts[(i + 1) % count], plane); }, *curves[i]);
      if (edge.IsNull()) return {};
      builder.Add(wire, edge);
    }
    wire.Closed(true);
    // The outer loop counter-clockwise, holes clockwise, whatever the sketch says.
    if ((signed_area(outline, loop) > 0) != (loop == 0)) wire.Reverse();
    builder.Add(face, wire);
  }
  return face;
}

/// A prism along z whose walls are turned about where they cross z = 0: planes stay planes, cylinders become cones.
TopoDS_Shape drafted(const TopoDS_Shape& prism, double angle) {
  const gp_Pln neutral(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1));
  BRepOffsetAPI_DraftAngle operation(prism);
  for (TopExp_Explorer faces(prism, TopAbs_FACE); faces.More(); faces.Next()) {
    const TopoDS_Face& face = TopoDS::Face(faces.Current());
    const BRepAdaptor_Surface surface(face, false);
    const bool cap = surface.GetType() == GeomAbs_Plane && std::abs(surface.Plane().Axis().Direction().Z()) > 0.5;
    if (cap) continue;
    operation.Add(face, gp_Dir(0, 0, 1), angle, neutral);
    if (!operation.AddDone()) return {};
  }
  operation.Build();
  return operation.IsDone() ? operation.Shape() : TopoDS_Shape();
}

TopoDS_Shape outward(TopoDS_Shape shape) {
  if (!shape.IsNull() && shape.ShapeType() == TopAbs_SOLID) BRepLib::OrientClosedSolid(TopoDS::Solid(shape));
  return shape;
}

}  // namespace

TopoDS_Shape brep_of(const BoxOf<double>& s) { return BRepPrimAPI_MakeBox(s.size_x, s.size_y, s.size_z).Shape(); }

TopoDS_Shape brep_of(const WedgeOf<double>& s) {
  return BRepPrimAPI_MakeWedge(s.size_x, s.size_y, s.size_z, s.top_x).Shape();
}

TopoDS_Shape brep_of(const CylinderOf<double>& s) { return BRepPrimAPI_MakeCylinder(s.radius, s.height).Shape(); }

TopoDS_Shape brep_of(const ConeOf<double>& s) {
  if (std::abs(s.bottom_radius - s.top_radius) < 1e-7)
    return BRepPrimAPI_MakeCylinder(s.bottom_radius, s.height).Shape();
  return BRepPrimAPI_MakeCone(s.bottom_radius, s.top_radius, s.height).Shape();
}

TopoDS_Shape brep_of(const SphereOf<double>& s) { return BRepPrimAPI_MakeSphere(s.radius).Shape(); }

TopoDS_Shape brep_of(const EllipsoidOf<double>& s) {
  gp_GTrsf scale;
  scale.SetValue(1, 1, s.radius_x);
  scale.SetValue(2, 2, s.radius_y);
  scale.SetValue(3, 3, s.radius_z);
  const TopoDS_Shape unit = BRepPrimAPI_MakeSphere(1).Shape();
  return outward(BRepBuilderAPI_GTransform(unit, scale, true).Shape());
}

TopoDS_Shape brep_of(const TorusOf<double>& s) { return BRepPrimAPI_MakeTorus(s.major_radius, s.minor_radius).Shape(); }

TopoDS_Shape brep_of(const HalfSpacesOf<double>& s) {
  std::vector<Plane3> planes;
  for (const auto& h : s.planes) planes.push_back({Vec3(h.normal_x, h.normal_y, h.normal_z), h.offset});
  const auto polyhedron = convex_polyhedron(planes);
  if (!polyhedron) return {};
  std::vector<std::vector<std::uint32_t>> polygons;
  for (const auto& face : polyhedron->faces) {
    if (face.size() >= 3) polygons.push_back(face);
  }
  return brep_of_polygons(polyhedron->vertices, polygons, true);
}

TopoDS_Shape brep_of(const ExtrudeOf<double>& s) {
  const TopoDS_Face face = face_of(s.sketch, {gp_Ax3(gp_Pnt(0, 0, -s.below), gp_Dir(0, 0, 1), gp_Dir(1, 0, 0))});
  if (face.IsNull()) return {};
  const TopoDS_Shape prism = BRepPrimAPI_MakePrism(face, gp_Vec(0, 0, s.below + s.height)).Shape();
  return outward(s.draft == 0 ? prism : drafted(prism, s.draft));
}

TopoDS_Shape brep_of(const RevolveOf<double>& s) {
  // Drawn in the x-z plane: its second axis is z when its normal is -y.
  const TopoDS_Face face = face_of(s.sketch, {gp_Ax3(gp_Pnt(0, 0, 0), gp_Dir(0, -1, 0), gp_Dir(1, 0, 0))});
  if (face.IsNull()) return {};
  const gp_Ax1 axis(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1));
  if (s.angle > 2 * pi - 1e-9) return outward(BRepPrimAPI_MakeRevol(face, axis).Shape());
  return outward(BRepPrimAPI_MakeRevol(face, axis, s.angle).Shape());
}

TopoDS_Shape brep_of(const TriSurfaceOf<double>& s) {
  std::vector<Vec3> vertices;
  for (const auto& v : s.vertices) vertices.emplace_back(v[0], v[1], v[2]);
  std::vector<std::vector<std::uint32_t>> polygons;
  for (const auto& t : s.triangles) polygons.push_back({t[0], t[1], t[2]});
  return brep_of_polygons(vertices, polygons, s.closed);
}

double area_of(const TopoDS_Shape& shape) {
  GProp_GProps properties;
  BRepGProp::SurfaceProperties(shape, properties);
  return properties.Mass();
}

}  // namespace partscribe::codegen
