#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Copy.hxx>
#include <BRepLib.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRepTools_WireExplorer.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <Eigen/Geometry>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom2d_Line.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <GeomConvert.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_Circle.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_Curve.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Line.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_Surface.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <cmath>
#include <gp_Circ.hxx>
#include <gp_Cone.hxx>
#include <gp_Cylinder.hxx>
#include <gp_Lin.hxx>
#include <gp_Pln.hxx>
#include <gp_Sphere.hxx>
#include <gp_Torus.hxx>

#include "core/number.h"
// Its types are made of OpenCASCADE's: it stands below these.
// clang-format off
#include "verify/exchange/brep_parts.h"
#include "verify/exchange/nurbs_of.h"
// clang-format on

namespace partscribe::verify {
namespace {

Vec3 vec(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }

NurbsSurface spline_of(const Handle(Geom_BSplineSurface) & given) {
  const auto surface = Handle(Geom_BSplineSurface)::DownCast(given->Copy());
  if (surface->IsUPeriodic()) surface->SetUNotPeriodic();
  if (surface->IsVPeriodic()) surface->SetVNotPeriodic();
  return nurbs_of(*surface);
}

void take_surface(BrepFace& face, Handle(Geom_Surface) surface) {
  while (true) {
    const auto trimmed = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface);
    if (trimmed.IsNull()) break;
    surface = trimmed->BasisSurface();
  }
  surface->Bounds(face.u.low, face.u.high, face.v.low, face.v.high);
  auto period = [](ParameterRange& range, bool periodic, bool closed) {
    if (periodic || closed) range.period = range.high - range.low;
  };
  const bool spline =
      surface->IsKind(STANDARD_TYPE(Geom_BSplineSurface)) || surface->IsKind(STANDARD_TYPE(Geom_BezierSurface));
  period(face.u, surface->IsUPeriodic(), spline && surface->IsUClosed());
  period(face.v, surface->IsVPeriodic(), spline && surface->IsVClosed());
  if (auto plane = Handle(Geom_Plane)::DownCast(surface))
    face.surface = plane->Pln();
  else if (auto cylinder = Handle(Geom_CylindricalSurface)::DownCast(surface))
    face.surface = cylinder->Cylinder();
  else if (auto cone = Handle(Geom_ConicalSurface)::DownCast(surface))
    face.surface = cone->Cone();
  else if (auto sphere = Handle(Geom_SphericalSurface)::DownCast(surface))
    face.surface = sphere->Sphere();
  else if (auto torus = Handle(Geom_ToroidalSurface)::DownCast(surface);
           torus && torus->MajorRadius() > torus->MinorRadius())
    face.surface = torus->Torus();
  else if (auto bspline = Handle(Geom_BSplineSurface)::DownCast(surface))
    face.surface = spline_of(bspline);
  else if (surface->IsKind(STANDARD_TYPE(Geom_BezierSurface)))
    face.surface = spline_of(GeomConvert::SurfaceToBSplineSurface(surface));
  else
    face.surface = surface;
}

bool take_curve(BrepEdge& edge, const TopoDS_Edge& shape) {
  Handle(Geom_Curve) curve = BRep_Tool::Curve(shape, edge.first, edge.last);
  if (curve.IsNull()) return false;
  while (true) {
    const auto trimmed = Handle(Geom_TrimmedCurve)::DownCast(curve);
    if (trimmed.IsNull()) break;
    curve = trimmed->BasisCurve();
  }
  if (auto line = Handle(Geom_Line)::DownCast(curve))
    edge.curve = line->Lin();
  else if (auto circle = Handle(Geom_Circle)::DownCast(curve))
    edge.curve = circle->Circ();
  else if (auto bspline = Handle(Geom_BSplineCurve)::DownCast(curve); bspline && !bspline->IsPeriodic()) {
    edge.curve = nurbs_of(*bspline);
  } else
    edge.curve = curve;
  return true;
}

TrimCurve trim_curve(Handle(Geom2d_Curve) curve, double first, double last, bool backward) {
  while (true) {
    const auto trimmed = Handle(Geom2d_TrimmedCurve)::DownCast(curve);
    if (trimmed.IsNull()) break;
    curve = trimmed->BasisCurve();
  }
  TrimCurve result;
  result.at = [curve](double t) {
    const gp_Pnt2d p = curve->Value(t);
    return Vec2(p.X(), p.Y());
  };
  result.first = first, result.last = last;
  result.straight = curve->IsKind(STANDARD_TYPE(Geom2d_Line));
  if (auto spline = Handle(Geom2d_BSplineCurve)::DownCast(curve)) {
    result.straight = spline->Degree() == 1 && spline->NbPoles() == 2;
    for (int i = 1; i <= spline->NbKnots(); ++i)
      if (spline->Knot(i) > first && spline->Knot(i) < last) result.kinks.push_back(spline->Knot(i));
  }
  if (backward) std::swap(result.first, result.last);
  return result;
}

TrimRegion trim_of(const TopoDS_Face& face, const BrepFace& surface) {
  std::vector<std::vector<TrimCurve>> loops;
  for (TopExp_Explorer wires(face, TopAbs_WIRE); wires.More(); wires.Next()) {
    const TopoDS_Wire wire = TopoDS::Wire(wires.Current());
    std::vector<TopoDS_Edge> edges, unordered;
    for (BRepTools_WireExplorer e(wire, face); e.More(); e.Next()) edges.push_back(e.Current());
    for (TopExp_Explorer e(wire, TopAbs_EDGE); e.More(); e.Next()) unordered.push_back(TopoDS::Edge(e.Current()));
    if (edges.size() != unordered.size()) edges = unordered;
    std::vector<TrimCurve> loop;
    for (const auto& edge : edges) {
      if (edge.Orientation() != TopAbs_FORWARD && edge.Orientation() != TopAbs_REVERSED) continue;
      double first = 0, last = 0;
      const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(edge, face, first, last);
      if (!curve.IsNull()) loop.push_back(trim_curve(curve, first, last, edge.Orientation() == TopAbs_REVERSED));
    }
    if (!loop.empty()) loops.push_back(std::move(loop));
  }
  if (loops.empty()) {  // bounded by its surface alone
    const Vec2 corner[4] = {{surface.u.low, surface.v.low},
                            {surface.u.high, surface.v.low},
                            {surface.u.high, surface.v.high},
                            {surface.u.low, surface.v.high}};
    std::vector<TrimCurve> loop;
    for (int k = 0; k < 4; ++k) {
      const Vec2 a = corner[k], b = corner[(k + 1) % 4];
      loop.push_back({[a, b](double t) { return Vec2(a + t * (b - a)); }, 0, 1, true, {}});
    }
    loops.push_back(std::move(loop));
  }
  return TrimRegion(std::move(loops));
}

double off_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double l = ab.squaredNorm();
  return (p - a - (l > 0 ? std::clamp(ab.dot(p - a) / l, 0.0, 1.0) : 0.0) * ab).norm();
}

class Collector {
 public:
  explicit Collector(const TopoDS_Shape& given)
      : shape_(BRepBuilderAPI_Copy(given, Standard_False, Standard_False).Shape()) {}

  std::unique_ptr<BrepDistance::Parts> run() {
    BRepLib::BuildCurves3d(shape_);
    Bnd_Box box;
    BRepBndLib::Add(shape_, box);
    if (box.IsVoid()) return nullptr;
    size_ = std::sqrt(box.SquareExtent());
    if (!(size_ > 0) || !std::isfinite(size_) || !mesh()) return nullptr;
    TopExp::MapShapes(shape_, TopAbs_EDGE, edge_map_);
    TopExp::MapShapes(shape_, TopAbs_VERTEX, vertex_map_);
    segments_of_.resize(std::size_t(edge_map_.Extent()) + 1);
    edge_index_.assign(std::size_t(edge_map_.Extent()) + 1, ~0u);
    vertex_normal_.assign(std::size_t(vertex_map_.Extent()) + 1, Vec3::Zero());
    for (TopExp_Explorer faces(shape_, TopAbs_FACE); faces.More(); faces.Next())
      if (!take_face(TopoDS::Face(faces.Current()))) return nullptr;
    if (parts_->mesh.empty()) return nullptr;
    finish_edges();
    finish_triangles();
    parts_->tree = build_triangle_tree(parts_->mesh, 1);
    return std::move(parts_);
  }

 private:
  TopoDS_Shape shape_;
  double size_ = 0;
  std::unique_ptr<BrepDistance::Parts> parts_ = std::make_unique<BrepDistance::Parts>();
  TopTools_IndexedMapOfShape edge_map_, vertex_map_;
  std::vector<std::vector<std::uint32_t>> segments_of_;  // by edge of the map, in order of its nodes
  std::vector<std::uint32_t> edge_index_;                // into parts_->edges
  std::vector<Vec3> vertex_normal_;
  std::vector<std::array<int, 2>> edge_vertices_;  // beside parts_->edges

  /// The mesher may leave a part of a face out without a word. In the parameter plane its triangles must fill the
  /// polygon of its border nodes.
  static bool filled(const TopoDS_Face& given) {
    const TopoDS_Face face = TopoDS::Face(given.Oriented(TopAbs_FORWARD));
    TopLoc_Location location;
    const auto triangulation = BRep_Tool::Triangulation(face, location);
    if (triangulation.IsNull() || !triangulation->HasUVNodes()) return false;
    auto doubled = [&](int a, int b) { return triangulation->UVNode(a).XY().Crossed(triangulation->UVNode(b).XY()); };
    double inside = 0, border = 0, seams = 0;
    for (int i = 1; i <= triangulation->NbTriangles(); ++i) {
      int a, b, c;
      triangulation->Triangle(i).Get(a, b, c);
      inside += std::abs(doubled(a, b) + doubled(b, c) + doubled(c, a));
    }
    for (TopExp_Explorer explorer(face, TopAbs_EDGE); explorer.More(); explorer.Next()) {
      const TopoDS_Edge edge = TopoDS::Edge(explorer.Current());
      const auto polygon = BRep_Tool::PolygonOnTriangulation(edge, triangulation, location);
      if (polygon.IsNull()) return false;
      const auto& nodes = polygon->Nodes();
      double sum = 0;
      for (int i = nodes.Lower(); i < nodes.Upper(); ++i) sum += doubled(nodes(i), nodes(i + 1));
      double& part = BRep_Tool::IsClosed(edge, face) ? seams : border;
      if (edge.Orientation() == TopAbs_FORWARD) part += sum;
      if (edge.Orientation() == TopAbs_REVERSED) part -= sum;
    }
    // Which of a seam's two sides the mesher calls the first one is not told.
    auto agrees = [&](double area) { return std::abs(inside - area) <= 1e-6 * inside; };
    return agrees(std::abs(border + seams)) || agrees(std::abs(border - seams));
  }

  bool mesh() {
    struct Fineness {
      double deflection, turn;  // share of the size; rad per chord
    };
    for (const auto& fineness : {Fineness{2e-4, 0.25}, {1e-4, 0.2}, {4e-4, 0.35}, {3e-5, 0.1}, {1e-3, 0.5}}) {
      BRepTools::Clean(shape_);
      BRepMesh_IncrementalMesh(shape_, fineness.deflection * size_, Standard_False, fineness.turn, Standard_False);
      bool whole = true;
      for (TopExp_Explorer faces(shape_, TopAbs_FACE); faces.More() && whole; faces.Next())
        whole = filled(TopoDS::Face(faces.Current()));
      if (whole) return true;
    }
    return false;
  }

  /// The segments of an edge, made when its first face comes by; null if two faces cut it differently.
  const std::vector<std::uint32_t>* segments(int e, const TopoDS_Edge& edge, const Poly_PolygonOnTriangulation& polygon,
                                             std::uint32_t face) {
    auto& list = segments_of_[std::size_t(e)];
    const auto count = std::size_t(polygon.NbNodes());
    if (!list.empty()) return list.size() + 1 == count ? &list : nullptr;
    if (count < 2 || !polygon.HasParameters()) return nullptr;
    BrepEdge own;
    if (!take_curve(own, edge)) return nullptr;
    own.face = face;
    own.first_segment = static_cast<std::uint32_t>(parts_->segments.size());
    own.segments = static_cast<std::uint32_t>(count - 1);
    const auto index = static_cast<std::uint32_t>(parts_->edges.size());
    edge_index_[std::size_t(e)] = index;
    parts_->edges.push_back(std::move(own));
    TopoDS_Vertex from, to;
    TopExp::Vertices(TopoDS::Edge(edge.Oriented(TopAbs_FORWARD)), from, to);
    edge_vertices_.push_back(
        {from.IsNull() ? 0 : vertex_map_.FindIndex(from), to.IsNull() ? 0 : vertex_map_.FindIndex(to)});
    const auto& parameters = polygon.Parameters()->Array1();
    for (std::size_t i = 0; i + 1 < count; ++i) {
      BrepSegment segment;
      segment.edge = index;
      segment.t0 = parameters(parameters.Lower() + int(i)), segment.t1 = parameters(parameters.Lower() + int(i) + 1);
      list.push_back(static_cast<std::uint32_t>(parts_->segments.size()));
      parts_->segments.push_back(segment);
    }
    return &list;
  }

  bool take_face(const TopoDS_Face& given) {
    const TopoDS_Face face = TopoDS::Face(given.Oriented(TopAbs_FORWARD));
    const auto index = static_cast<std::uint32_t>(parts_->faces.size());
    BrepFace& own = parts_->faces.emplace_back();
    const Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
    if (surface.IsNull()) return false;
    take_surface(own, surface);
    own.reversed = given.Orientation() == TopAbs_REVERSED;
    own.trim = trim_of(face, own);

    TopLoc_Location location;
    const auto triangulation = BRep_Tool::Triangulation(face, location);
    const gp_Trsf world_from_face = location.Transformation();
    const auto first = static_cast<std::uint32_t>(parts_->mesh.vertices.size());
    const auto nodes = static_cast<std::size_t>(triangulation->NbNodes());
    std::vector<Vec2> uv(nodes);
    std::vector<Vec3> normal(nodes, Vec3::Zero());
    std::vector<int> vertex(nodes, 0);
    for (std::size_t i = 0; i < nodes; ++i) {
      parts_->mesh.vertices.push_back(vec(triangulation->Node(int(i) + 1).Transformed(world_from_face)));
      const gp_Pnt2d p = triangulation->UVNode(int(i) + 1);
      uv[i] = {p.X(), p.Y()};
      const SurfacePoint s = surface_point(own, p.X(), p.Y());
      const Vec3 n = s.du.cross(s.dv);
      const double length = n.norm();
      if (length > 1e-9 * (s.du.squaredNorm() + s.dv.squaredNorm())) normal[i] = (own.reversed ? -1 : 1) / length * n;
    }
    struct Side {
      std::uint64_t nodes;
      std::uint32_t segment;
    };
    std::vector<Side> sides;
    for (TopExp_Explorer explorer(face, TopAbs_EDGE); explorer.More(); explorer.Next()) {
      const TopoDS_Edge edge = TopoDS::Edge(explorer.Current());
      const auto polygon = BRep_Tool::PolygonOnTriangulation(edge, triangulation, location);
      if (polygon.IsNull()) return false;
      TopoDS_Vertex from, to;
      TopExp::Vertices(TopoDS::Edge(edge.Oriented(TopAbs_FORWARD)), from, to);
      const auto& list = polygon->Nodes();
      auto node = [&](int i) { return static_cast<std::size_t>(list(list.Lower() + i)) - 1; };
      const int count = polygon->NbNodes();
      if (!from.IsNull()) vertex[node(0)] = vertex_map_.FindIndex(from);
      if (!to.IsNull()) vertex[node(count - 1)] = vertex_map_.FindIndex(to);
      if (BRep_Tool::Degenerated(edge)) continue;
      const auto* own_segments = segments(edge_map_.FindIndex(edge), edge, *polygon, index);
      if (!own_segments) return false;
      for (int i = 0; i + 1 < count; ++i) {
        const std::uint64_t a = node(i), b = node(i + 1);
        const std::uint32_t s = (*own_segments)[std::size_t(i)];
        sides.push_back({std::min(a, b) << 32 | std::max(a, b), s});
        parts_->segments[s].normal_a += normal[a], parts_->segments[s].normal_b += normal[b];
      }
    }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.nodes < b.nodes; });
    for (int i = 1; i <= triangulation->NbTriangles(); ++i) {
      int n[3];
      triangulation->Triangle(i).Get(n[0], n[1], n[2]);
      BrepTriangle triangle;
      triangle.face = index;
      std::array<std::uint32_t, 3> corner;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto a = std::size_t(n[k] - 1), b = std::size_t(n[(k + 1) % 3] - 1), c = std::size_t(n[(k + 2) % 3] - 1);
        corner[k] = first + static_cast<std::uint32_t>(a);
        triangle.uv[k] = uv[a];
        const std::uint64_t key = std::uint64_t(std::min(a, b)) << 32 | std::max(a, b);
        const auto side = std::lower_bound(sides.begin(), sides.end(), key,
                                           [](const Side& s, std::uint64_t x) { return s.nodes < x; });
        if (side != sides.end() && side->nodes == key) triangle.segment[k] = side->segment;
        const Vec3 ab = parts_->mesh.vertices[first + b] - parts_->mesh.vertices[first + a];
        const Vec3 ac = parts_->mesh.vertices[first + c] - parts_->mesh.vertices[first + a];
        if (vertex[a] > 0)
          vertex_normal_[std::size_t(vertex[a])] += std::atan2(ab.cross(ac).norm(), ab.dot(ac)) * normal[a];
      }
      parts_->mesh.triangles.push_back(corner);
      parts_->triangles.push_back(triangle);
    }
    return true;
  }

  void finish_edges() {
    for (std::size_t e = 0; e < parts_->edges.size(); ++e) {
      parts_->edges[e].start_normal = vertex_normal_[std::size_t(edge_vertices_[e][0])];
      parts_->edges[e].end_normal = vertex_normal_[std::size_t(edge_vertices_[e][1])];
    }
    for (std::size_t e = 1; e < segments_of_.size(); ++e)
      for (const std::uint32_t s : segments_of_[e]) {
        BrepSegment& segment = parts_->segments[s];
        const BrepEdge& edge = parts_->edges[segment.edge];
        segment.a = curve_point(edge, segment.t0).p, segment.b = curve_point(edge, segment.t1).p;
        double worst = 0;
        for (int i = 1; i < 10; ++i)
          worst = std::max(worst, off_segment(curve_point(edge, segment.t0 + (segment.t1 - segment.t0) * i / 10).p,
                                              segment.a, segment.b));
        const double tolerance = BRep_Tool::Tolerance(TopoDS::Edge(edge_map_(int(e))));
        segment.slack = 1.3 * worst + std::min(tolerance, 1e-3 * size_) + 1e-10 * size_;
      }
  }

  void finish_triangles() {
    for (std::size_t t = 0; t < parts_->triangles.size(); ++t) {
      BrepTriangle& triangle = parts_->triangles[t];
      const BrepFace& face = parts_->faces[triangle.face];
      const Vec3 a = parts_->mesh.corner(t, 0), b = parts_->mesh.corner(t, 1), c = parts_->mesh.corner(t, 2);
      double worst = 0;
      constexpr int steps = 5;
      for (int i = 0; i <= steps; ++i)
        for (int j = 0; i + j <= steps; ++j) {
          const double x = double(i) / steps, y = double(j) / steps, z = 1 - x - y;
          const Vec2 uv = x * triangle.uv[0] + y * triangle.uv[1] + z * triangle.uv[2];
          worst = std::max(worst,
                           std::sqrt(nearest_in_triangle(a, b, c, surface_point(face, uv.x(), uv.y()).p).sq_distance));
        }
      double border = 0;
      for (const auto s : triangle.segment)
        if (s != no_segment) border = std::max(border, parts_->segments[s].slack);
      triangle.slack = 1.5 * worst + border + 1e-10 * size_;
      parts_->most_slack = std::max(parts_->most_slack, triangle.slack);
    }
  }
};

}  // namespace

TriangleFoot nearest_in_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 ab = b - a, bc = c - b, ca = a - c, n = ab.cross(-ca);
  const double nn = n.squaredNorm();
  if (nn > 0) {
    const double x = n.dot(bc.cross(p - b)) / nn, y = n.dot(ca.cross(p - c)) / nn, z = 1 - x - y;
    if (x >= 0 && y >= 0 && z >= 0) return {(p - x * a - y * b - z * c).squaredNorm(), {x, y, z}};
  }
  TriangleFoot best{HUGE_VAL, Vec3::Zero()};
  const Vec3 corner[3] = {a, b, c}, side[3] = {ab, bc, ca};
  for (int k = 0; k < 3; ++k) {
    const double l = side[k].squaredNorm();
    const double s = l > 0 ? std::clamp(side[k].dot(p - corner[k]) / l, 0.0, 1.0) : 0;
    const double sq = (p - corner[k] - s * side[k]).squaredNorm();
    if (sq < best.sq_distance) {
      best.sq_distance = sq, best.weights = Vec3::Zero();
      best.weights[k] = 1 - s, best.weights[(k + 1) % 3] += s;
    }
  }
  return best;
}

std::unique_ptr<BrepDistance::Parts> collect_brep_parts(const TopoDS_Shape& shape) { return Collector(shape).run(); }

}  // namespace partscribe::verify
