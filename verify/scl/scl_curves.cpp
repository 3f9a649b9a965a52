/// Curves, profiles and B-spline surfaces of Alpha_1 procedures as OCCT edges, wires and faces.
#include <BRepAdaptor_Curve.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GC_MakeArcOfCircle.hxx>
#include <GC_MakeSegment.hxx>
#include <GeomConvert.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <Standard_Failure.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColStd_Array2OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <cmath>

#include "verify/scl/scl_shape.h"

namespace partscribe::verify {
namespace {

gp_Pnt pnt(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
Vec3 vec3(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }

SclGeometryPtr made(SclGeometryKind kind, const TopoDS_Shape& shape) {
  auto geometry = std::make_shared<SclGeometry>();
  geometry->kind = kind;
  geometry->shape = std::make_shared<const TopoDS_Shape>(shape);
  return geometry;
}

Error refuse(const std::string& what) { return bad_input(what); }

Error failure(const char* what, const Standard_Failure& cause) {
  return bad_input(std::string(what) + ": " +
                   (cause.GetMessageString() ? cause.GetMessageString() : "geometry kernel failed"));
}

SclMade edge_of(SclGeometryKind kind, const Handle(Geom_Curve) & curve) {
  BRepBuilderAPI_MakeEdge maker(curve);
  if (!maker.IsDone()) return refuse("the curve has no length");
  return made(kind, maker.Edge());
}

/// The curve under an edge with its ends.
struct Piece {
  Handle(Geom_Curve) curve;
  double first = 0, last = 0;
  Vec3 start() const { return vec3(curve->Value(first)); }
  Vec3 end() const { return vec3(curve->Value(last)); }
};

Piece piece_of(const TopoDS_Shape& edge) {
  Piece piece;
  piece.curve = BRep_Tool::Curve(TopoDS::Edge(edge), piece.first, piece.last);
  return piece;
}

/// Distinct values and how often each occurs.
void split_knots(const std::vector<double>& knots, std::vector<double>& values, std::vector<int>& multiplicities) {
  for (const double k : knots) {
    if (!values.empty() && k == values.back())
      ++multiplicities.back();
    else
      values.push_back(k), multiplicities.push_back(1);
  }
}

/// What is wrong with a knot vector for `count` points of `order`; empty if nothing.
std::string knot_trouble(const std::vector<double>& knots, std::size_t count, int order, bool clamped) {
  if (knots.size() != count + static_cast<std::size_t>(order))
    return "expected " + std::to_string(count + static_cast<std::size_t>(order)) + " knots for " +
           std::to_string(count) + " points of order " + std::to_string(order) + ", found " +
           std::to_string(knots.size());
  if (!std::is_sorted(knots.begin(), knots.end())) return "expected knots in ascending order";
  std::vector<double> values;
  std::vector<int> multiplicities;
  split_knots(knots, values, multiplicities);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool at_end = i == 0 || i + 1 == values.size();
    if (multiplicities[i] > (at_end ? order : order - 1))
      return "expected a knot to occur at most " + std::to_string(at_end ? order : order - 1) + " times, found " +
             std::to_string(multiplicities[i]);
    if (clamped && at_end && multiplicities[i] != order)
      return "expected the first and last knot of an open end condition " + std::to_string(order) + " times";
  }
  if (values.size() < 2) return "expected at least two different knots";
  return {};
}

/// A direction with all its knots, and how many points are repeated at its end.
struct Resolved {
  std::vector<double> knots;
  std::size_t wrap = 0;
  double first = 0, last = 1;  // the domain
};

Result<Resolved> resolved(const SclDirection& d, std::size_t count, const char* name) {
  const auto order = static_cast<std::size_t>(d.order);
  const std::size_t degree = order - 1;
  const std::string where = std::string("direction ") + name + ": ";
  if (d.order < 2 || d.order > 12)
    return refuse(where + "expected an order from 2 to 12, found " + std::to_string(d.order));
  const std::size_t fewest = d.end == SclEnd::periodic ? std::max<std::size_t>(3, order - 1) : order;
  if (count < fewest)
    return refuse(where + "expected at least " + std::to_string(fewest) + " points, found " + std::to_string(count));
  Resolved r;
  if (d.end == SclEnd::periodic) {
    if (!d.knots.empty() || d.bezier) return refuse(where + "expected \"kv_uniform\" with \"ec_periodic\"");
    r.wrap = degree;
  }
  const std::size_t total = count + r.wrap;
  if (d.bezier) {
    if (d.end != SclEnd::open || count != order)
      return refuse(where + "expected as many points as the order and \"ec_open\" with \"kv_bezier\"");
    r.knots.assign(order, 0.0);
    r.knots.insert(r.knots.end(), order, 1.0);
  } else if (!d.knots.empty()) {
    if (const auto trouble = knot_trouble(d.knots, count, d.order, d.end == SclEnd::open); !trouble.empty())
      return refuse(where + trouble);
    r.knots = d.knots;
  } else {
    for (std::size_t i = 0; i < total + order; ++i) {
      double knot = static_cast<double>(i) - static_cast<double>(degree);
      if (d.end == SclEnd::open) knot = std::clamp(knot, 0.0, static_cast<double>(total - degree));
      r.knots.push_back(knot);
    }
  }
  r.first = r.knots[degree];
  r.last = r.knots[r.knots.size() - order];
  if (!(r.first < r.last)) return refuse(where + "expected a knot vector with a domain");
  return r;
}

TColStd_Array1OfReal reals(const std::vector<double>& values) {
  TColStd_Array1OfReal array(1, static_cast<int>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) array.SetValue(static_cast<int>(i) + 1, values[i]);
  return array;
}

TColStd_Array1OfInteger integers(const std::vector<int>& values) {
  TColStd_Array1OfInteger array(1, static_cast<int>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) array.SetValue(static_cast<int>(i) + 1, values[i]);
  return array;
}

SclMade face_of(const Handle(Geom_BSplineSurface) & surface) {
  BRepBuilderAPI_MakeFace maker(surface, 1e-7);
  if (!maker.IsDone()) return refuse("the surface has no area");
  auto geometry = std::make_shared<SclGeometry>();
  geometry->kind = SclGeometryKind::surface;
  geometry->shape = std::make_shared<const TopoDS_Shape>(maker.Face());
  geometry->natural = true;
  return SclGeometryPtr(geometry);
}

}  // namespace

const char* name_of(SclGeometryKind kind) {
  switch (kind) {
    case SclGeometryKind::line:
      return "a line";
    case SclGeometryKind::arc:
      return "an arc";
    case SclGeometryKind::circle:
      return "a circle";
    case SclGeometryKind::curve:
      return "a curve";
    case SclGeometryKind::profile:
      return "a profile";
    case SclGeometryKind::surface:
      return "a surface";
    case SclGeometryKind::primitive:
      return "a primitive";
    case SclGeometryKind::shell:
      return "a shell";
    case SclGeometryKind::group:
      return "a group";
  }
  return "a geometry";
}

SclGeometryKind kind_of(const SclGeometry& geometry) { return geometry.kind; }
bool is_solid(const SclGeometry& geometry) { return geometry.solid; }
const std::vector<SclGeometryPtr>& members_of(const SclGeometry& geometry) { return geometry.members; }

SclMade scl_line(const Vec3& a, const Vec3& b) {
  if ((a - b).norm() <= scl_join) return refuse("the two points of a line coincide");
  return edge_of(SclGeometryKind::line, GC_MakeSegment(pnt(a), pnt(b)).Value());
}

SclMade scl_arc_through(const Vec3& a, const Vec3& b, const Vec3& c) {
  GC_MakeArcOfCircle maker(pnt(a), pnt(b), pnt(c));
  if ((a - b).norm() <= scl_join || (b - c).norm() <= scl_join || (c - a).norm() <= scl_join || !maker.IsDone())
    return refuse("the three points of an arc lie on a line or coincide");
  return edge_of(SclGeometryKind::arc, maker.Value());
}

SclMade scl_arc_about(const Vec3& a, const Vec3& center, const Vec3& b) {
  const Vec3 from = a - center, to = b - center;
  const double radius = from.norm();
  if (std::abs(radius - to.norm()) > 1e-5 * (1 + radius))
    return refuse("the ends of an arc are not equally far from its centre");
  const Vec3 half = from + to;
  if (half.norm() <= 1e-6 * radius)
    return refuse("the ends of an arc lie opposite each other: which way round is not told");
  return scl_arc_through(a, center + half * (radius / half.norm()), b);
}

SclMade scl_nurbs_curve(int order, const std::vector<double>& knots, const std::vector<Vec3>& points,
                        const std::vector<double>& weights) {
  if (order < 2 || order > 12) return refuse("expected an order from 2 to 12, found " + std::to_string(order));
  if (const auto trouble = knot_trouble(knots, points.size(), order, true); !trouble.empty()) return refuse(trouble);
  if (!weights.empty() && weights.size() != points.size())
    return refuse("expected a weight for each of " + std::to_string(points.size()) + " points, found " +
                  std::to_string(weights.size()));
  if (std::any_of(weights.begin(), weights.end(), [](double w) { return !(w > 0); }))
    return refuse("expected positive weights");
  std::vector<double> values;
  std::vector<int> multiplicities;
  split_knots(knots, values, multiplicities);
  TColgp_Array1OfPnt poles(1, static_cast<int>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) poles.SetValue(static_cast<int>(i) + 1, pnt(points[i]));
  try {
    Handle(Geom_BSplineCurve) curve =
        weights.empty()
            ? new Geom_BSplineCurve(poles, reals(values), integers(multiplicities), order - 1)
            : new Geom_BSplineCurve(poles, reals(weights), reals(values), integers(multiplicities), order - 1);
    return edge_of(SclGeometryKind::curve, curve);
  } catch (const Standard_Failure& f) {
    return failure("the NURBS curve is not valid", f);
  }
}

SclMade scl_curve_of(const SclGeometryPtr& arc) {
  try {
    const Piece piece = piece_of(*arc->shape);
    return edge_of(SclGeometryKind::curve,
                   GeomConvert::CurveToBSplineCurve(new Geom_TrimmedCurve(piece.curve, piece.first, piece.last)));
  } catch (const Standard_Failure& f) {
    return failure("the arc has no NURBS form", f);
  }
}

SclMade scl_profile(const std::vector<SclCorner>& corners) {
  std::vector<Piece> pieces;
  bool started = false;
  Vec3 pen = Vec3::Zero(), first = Vec3::Zero();
  auto move_to = [&](const Vec3& p) {
    if (!started)
      started = true, first = p;
    else if ((p - pen).norm() > scl_join) {
      Handle(Geom_TrimmedCurve) segment = GC_MakeSegment(pnt(pen), pnt(p)).Value();
      pieces.push_back({segment, segment->FirstParameter(), segment->LastParameter()});
    }
    pen = p;
  };
  for (const auto& corner : corners) {
    if (!corner.curve) {
      move_to(corner.point);
      continue;
    }
    if (corner.curve->kind == SclGeometryKind::profile)
      return refuse("a profile is joined from points, lines, arcs and curves");
    const Piece piece = piece_of(*corner.curve->shape);
    move_to(piece.start());
    pieces.push_back(piece);
    pen = piece.end();
  }
  if (pieces.empty()) return refuse("a profile needs two different corners");
  const bool closed = (pen - first).norm() <= scl_join;
  if (closed && pieces.size() == 1 && (pieces[0].start() - pieces[0].end()).norm() > scl_join)
    return refuse("a profile has no length");

  // By hand, because the joints may be open by more than the kernel's own 1e-7.
  BRep_Builder builder;
  std::vector<TopoDS_Vertex> joints;
  for (const auto& piece : pieces) {
    TopoDS_Vertex v;
    builder.MakeVertex(v, pnt(piece.start()), 2 * scl_join);
    joints.push_back(v);
  }
  if (closed) {
    joints.push_back(joints.front());
  } else {
    TopoDS_Vertex v;
    builder.MakeVertex(v, pnt(pen), 2 * scl_join);
    joints.push_back(v);
  }
  TopoDS_Wire wire;
  builder.MakeWire(wire);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    TopoDS_Edge edge;
    builder.MakeEdge(edge, pieces[i].curve, 1e-7);
    builder.Add(edge, joints[i].Oriented(TopAbs_FORWARD));
    builder.Add(edge, joints[i + 1].Oriented(TopAbs_REVERSED));
    builder.Range(edge, pieces[i].first, pieces[i].last);
    builder.Add(wire, edge);
  }
  wire.Closed(closed);
  return made(SclGeometryKind::profile, wire);
}

SclMade scl_surface(const SclDirection& u, const SclDirection& v, const std::vector<std::vector<Vec3>>& mesh,
                    const std::vector<std::vector<double>>& weights) {
  if (mesh.empty()) return refuse("expected a mesh of points, found an empty one");
  for (const auto& row : mesh)
    if (row.size() != mesh[0].size())
      return refuse("expected rows of equal length in the mesh, found " + std::to_string(mesh[0].size()) + " and " +
                    std::to_string(row.size()) + " points");
  if (!weights.empty()) {
    bool right = weights.size() == mesh.size();
    for (const auto& row : weights)
      right =
          right && row.size() == mesh[0].size() && std::all_of(row.begin(), row.end(), [](double w) { return w > 0; });
    if (!right) return refuse("expected a positive weight for each point of the mesh");
  }
  const auto ru = resolved(u, mesh[0].size(), "u");
  if (!ru.ok()) return ru.error();
  const auto rv = resolved(v, mesh.size(), "v");
  if (!rv.ok()) return rv.error();
  const std::size_t columns = mesh[0].size() + ru->wrap, rows = mesh.size() + rv->wrap;
  TColgp_Array2OfPnt poles(1, static_cast<int>(columns), 1, static_cast<int>(rows));
  TColStd_Array2OfReal shares(1, static_cast<int>(columns), 1, static_cast<int>(rows));
  for (std::size_t i = 0; i < columns; ++i)
    for (std::size_t j = 0; j < rows; ++j) {
      const int column = static_cast<int>(i) + 1, row = static_cast<int>(j) + 1;
      poles.SetValue(column, row, pnt(mesh[j % mesh.size()][i % mesh[0].size()]));
      shares.SetValue(column, row, weights.empty() ? 1 : weights[j % mesh.size()][i % mesh[0].size()]);
    }
  std::vector<double> uk, vk;
  std::vector<int> um, vm;
  split_knots(ru->knots, uk, um);
  split_knots(rv->knots, vk, vm);
  try {
    Handle(Geom_BSplineSurface) surface = new Geom_BSplineSurface(poles, shares, reals(uk), reals(vk), integers(um),
                                                                  integers(vm), u.order - 1, v.order - 1);
    if (um.front() != u.order || um.back() != u.order || vm.front() != v.order || vm.back() != v.order)
      surface->Segment(ru->first, ru->last, rv->first, rv->last);
    return face_of(surface);
  } catch (const Standard_Failure& f) {
    return failure("the surface is not valid", f);
  }
}

SclMade scl_refined(const SclGeometryPtr& geometry, bool row, const std::vector<double>& knots) {
  auto surface = Handle(Geom_BSplineSurface)::DownCast(BRep_Tool::Surface(TopoDS::Face(*geometry->shape))->Copy());
  if (surface.IsNull()) return refuse("expected a B-spline surface to refine");
  double u1, u2, v1, v2;
  surface->Bounds(u1, u2, v1, v2);
  const double low = row ? u1 : v1, high = row ? u2 : v2;
  const int degree = row ? surface->UDegree() : surface->VDegree();
  try {
    for (const double knot : knots) {
      if (!(knot > low && knot < high))
        return refuse("expected new knots between " + std::to_string(low) + " and " + std::to_string(high) +
                      ", found " + std::to_string(knot));
      const int count = row ? surface->NbUKnots() : surface->NbVKnots();
      int present = 0;
      for (int i = 1; i <= count; ++i)
        if (std::abs((row ? surface->UKnot(i) : surface->VKnot(i)) - knot) < 1e-12)
          present = row ? surface->UMultiplicity(i) : surface->VMultiplicity(i);
      if (present >= degree) return refuse("a knot would occur more often than the degree allows");
      if (row)
        surface->InsertUKnot(knot, present + 1, 1e-12, false);
      else
        surface->InsertVKnot(knot, present + 1, 1e-12, false);
    }
    return face_of(surface);
  } catch (const Standard_Failure& f) {
    return failure("the knots cannot be inserted", f);
  }
}

}  // namespace partscribe::verify
