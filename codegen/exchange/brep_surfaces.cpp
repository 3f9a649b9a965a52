#include <BRepGProp.hxx>
#include <BRepLib.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_Curve.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TColgp_Array1OfPnt2d.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <map>
#include <tuple>

#include "codegen/exchange/brep_shapes.h"
#include "core/disjoint_sets.h"
#include "geometry/surfaces/edge_curve.h"
#include "model/surface_patches.h"

namespace partscribe::codegen {
namespace {

gp_Pnt point(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

/// Different knots and how often each is there.
struct OcctKnots {
  TColStd_Array1OfReal knots;
  TColStd_Array1OfInteger multiplicities;

  static OcctKnots of(const KnotVector& t) {
    const auto different = t.multiplicities();
    const int count = static_cast<int>(different.size());
    OcctKnots result{TColStd_Array1OfReal(1, count), TColStd_Array1OfInteger(1, count)};
    for (int i = 0; i < count; ++i)
      std::tie(result.knots(i + 1), result.multiplicities(i + 1)) = different[static_cast<std::size_t>(i)];
    return result;
  }
};

Handle(Geom_BSplineSurface) occt_surface(const NurbsSurface& s) {
  TColgp_Array2OfPnt poles(1, s.u.count(), 1, s.v.count());
  TColStd_Array2OfReal weights(1, s.u.count(), 1, s.v.count());
  for (int i = 0; i < s.u.count(); ++i)
    for (int j = 0; j < s.v.count(); ++j) {
      const std::size_t at = static_cast<std::size_t>(i * s.v.count() + j);
      poles(i + 1, j + 1) = point(s.points[at]);
      weights(i + 1, j + 1) = s.weights.empty() ? 1 : s.weights[at];
    }
  const auto u = OcctKnots::of(s.u), v = OcctKnots::of(s.v);
  if (s.weights.empty())
    return new Geom_BSplineSurface(poles, u.knots, v.knots, u.multiplicities, v.multiplicities, s.u.degree, s.v.degree);
  return new Geom_BSplineSurface(poles, weights, u.knots, v.knots, u.multiplicities, v.multiplicities, s.u.degree,
                                 s.v.degree);
}

Handle(Geom_BSplineCurve) occt_curve(const NurbsCurve<3>& c) {
  const int count = static_cast<int>(c.points.size());
  TColgp_Array1OfPnt poles(1, count);
  for (int i = 0; i < count; ++i) poles(i + 1) = point(c.points[static_cast<std::size_t>(i)]);
  const auto t = OcctKnots::of(c.t);
  return new Geom_BSplineCurve(poles, t.knots, t.multiplicities, c.t.degree);
}

/// Over 0 .. 1; `reversed`: from its end to its beginning.
Handle(Geom2d_BSplineCurve) occt_curve(const NurbsCurve<2>& c, bool reversed) {
  KnotVector unit = c.t;
  for (double& knot : unit.knots) knot = (knot - c.t.low()) / (c.t.high() - c.t.low());
  const int count = static_cast<int>(c.points.size());
  TColgp_Array1OfPnt2d poles(1, count);
  for (int i = 0; i < count; ++i)
    poles(i + 1) = gp_Pnt2d(c.points[static_cast<std::size_t>(i)].x(), c.points[static_cast<std::size_t>(i)].y());
  const auto t = OcctKnots::of(unit);
  Handle(Geom2d_BSplineCurve) curve = new Geom2d_BSplineCurve(poles, t.knots, t.multiplicities, c.t.degree);
  if (reversed) curve->Reverse();
  return curve;
}

/// Edges of a set of surfaces: each is one edge of the boundary, with a curve on every surface that has it.
class EdgeMaker {
 public:
  /// Edges in space are within `tolerance` mm of the mean of their sides.
  EdgeMaker(std::span<const TrimmedSurface> surfaces, double tolerance) : ends_(surfaces) {
    for (const auto& [edge, of] : edge_sides(surfaces)) curves_.emplace(edge, edge_curve(of, tolerance));
  }

  /// The edge as a loop of this surface runs through it.
  TopoDS_Edge edge(const SurfaceTrim& trim, const Handle(Geom_BSplineSurface) & on) {
    const auto [at, is_new] = edges_.try_emplace(trim.edge);
    Made& made = at->second;
    const Handle(Geom2d_BSplineCurve) curve = occt_curve(trim.curve, !is_new);
    if (is_new) {
      builder_.MakeEdge(made.edge);
      builder_.UpdateEdge(made.edge, curve, on, TopLoc_Location(), 1e-7);
      builder_.Add(made.edge, vertex(trim.edge, false).Oriented(TopAbs_FORWARD));
      builder_.Add(made.edge, vertex(trim.edge, true).Oriented(TopAbs_REVERSED));
      builder_.UpdateEdge(made.edge, occt_curve(curves_.at(trim.edge)), 1e-7);
      builder_.Range(made.edge, 0, 1);
      made.on = on, made.curve = curve;
      cover(made.edge, curve, on);
      return made.edge;
    }
    if (made.on == on)  // a seam: the surface meets itself
      builder_.UpdateEdge(made.edge, made.curve, curve, on, TopLoc_Location(), 1e-7);
    else
      builder_.UpdateEdge(made.edge, curve, on, TopLoc_Location(), 1e-7);
    cover(made.edge, curve, on);
    return TopoDS::Edge(made.edge.Reversed());
  }

 private:
  struct Made {
    TopoDS_Edge edge;
    Handle(Geom_BSplineSurface) on;
    Handle(Geom2d_BSplineCurve) curve;
  };

  /// Equal parameters are equal places, so that the edge's tolerance is how far they are apart.
  void cover(const TopoDS_Edge& edge, const Handle(Geom2d_BSplineCurve) & curve,
             const Handle(Geom_BSplineSurface) & on) {
    double first, last, off = 0;
    const Handle(Geom_Curve) space = BRep_Tool::Curve(edge, first, last);
    if (space.IsNull()) return;
    const int samples = 16 * curve->NbKnots();
    for (int i = 0; i <= samples; ++i) {
      const double t = first + (last - first) * i / samples;
      const gp_Pnt2d uv = curve->Value(t);
      off = std::max(off, space->Value(t).Distance(on->Value(uv.X(), uv.Y())));
    }
    builder_.UpdateEdge(edge, std::max(1e-7, 1.1 * off));
    builder_.SameRange(edge, true), builder_.SameParameter(edge, true);
  }

  /// One vertex for all ends that are one place: the mean of the edges that end there.
  TopoDS_Vertex vertex(int edge, bool last) {
    const int place = ends_.place(edge, last);
    const auto [at, is_new] = vertices_.try_emplace(place);
    if (!is_new) return at->second;
    Vec3 sum = Vec3::Zero();
    int count = 0;
    for (const auto& [other, curve] : curves_)
      for (const bool end : {false, true})
        if (ends_.place(other, end) == place) sum += end ? curve.points.back() : curve.points.front(), ++count;
    builder_.MakeVertex(at->second, point(sum / count), 1e-7);
    return at->second;
  }

  EdgeEnds ends_;
  std::map<int, NurbsCurve<3>> curves_;
  BRep_Builder builder_;
  std::map<int, Made> edges_;
  std::map<int, TopoDS_Vertex> vertices_;
};

/// Of each surface the number of the connected piece that it belongs to, from 0.
std::vector<std::uint32_t> pieces_of(std::span<const TrimmedSurface> surfaces) {
  DisjointSets sets(surfaces.size());
  std::map<int, std::uint32_t> first;  // surface of each edge
  for (std::uint32_t f = 0; f < surfaces.size(); ++f)
    for (const auto& loop : surfaces[f].loops)
      for (const auto& trim : loop) sets.unite(first.try_emplace(trim.edge, f).first->second, f);
  return sets.numbers();
}

}  // namespace

TopoDS_Shape brep_of(const SurfaceSetOf<double>& s, double tolerance) {
  BRep_Builder builder;
  const auto surfaces = trimmed_surfaces(s.patches);
  const auto piece = pieces_of(surfaces);
  std::vector<TopoDS_Shell> shells;
  EdgeMaker edges(surfaces, tolerance);
  for (std::size_t f = 0; f < surfaces.size(); ++f) {
    const TrimmedSurface& trimmed = surfaces[f];
    const auto surface = occt_surface(trimmed.surface);
    TopoDS_Face face;
    builder.MakeFace(face, surface, 1e-7);
    for (const auto& loop : trimmed.loops) {
      TopoDS_Wire wire;
      builder.MakeWire(wire);
      for (const auto& trim : loop) builder.Add(wire, edges.edge(trim, surface));
      wire.Closed(true);
      builder.Add(face, wire);
    }
    if (piece[f] == shells.size()) builder.MakeShell(shells.emplace_back());
    builder.Add(shells[piece[f]], face);
  }
  for (TopoDS_Shell& shell : shells) shell.Closed(s.closed), BRepLib::UpdateTolerances(shell);
  if (!s.closed && shells.size() == 1) return shells[0];
  if (!s.closed) {
    TopoDS_Compound all;
    builder.MakeCompound(all);
    for (const TopoDS_Shell& shell : shells) builder.Add(all, shell);
    return all;
  }
  if (shells.size() == 1) {
    TopoDS_Solid solid;
    builder.MakeSolid(solid);
    builder.Add(solid, shells[0]);
    return solid;
  }
  std::vector<ClosedShell> closed;
  for (const TopoDS_Shell& shell : shells) {
    GProp_GProps inside;
    BRepGProp::VolumeProperties(shell, inside);
    closed.push_back({&shell, inside.Mass(), {}});
  }
  for (std::size_t f = 0; f < surfaces.size(); ++f)
    for (const Vec3& p : surfaces[f].surface.points) closed[piece[f]].bounds.add(p);
  return solids_of(closed);
}

}  // namespace partscribe::codegen
