#include "codegen/exchange/brep_faces.h"

#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Eigen/Geometry>
#include <GProp_GProps.hxx>
#include <GeomAPI_Interpolate.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_Circle.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Line.hxx>
#include <Geom_Plane.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <Poly_Triangulation.hxx>
#include <ShapeBuild_ReShape.hxx>
#include <ShapeFix_Shape.hxx>
#include <ShapeFix_Shell.hxx>
#include <ShapeFix_Solid.hxx>
#include <Standard_Failure.hxx>
#include <TColgp_HArray1OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopTools_DataMapOfShapeInteger.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <cmath>
#include <map>

#include "codegen/exchange/as_read.h"
#include "codegen/exchange/brep_shapes.h"
#include "codegen/exchange/face_borders.h"
#include "core/disjoint_sets.h"
#include "core/number.h"
#include "geometry/segment/faces.h"

namespace partscribe::codegen {
namespace {

constexpr int most_rounds = 8;  // of faces given up and all built again
constexpr double wrong_area = 0.05;
constexpr double widest_gap = 10;  // tolerances between a border and the faces beside it

gp_Pnt point(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
gp_Dir direction(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

/// The frame of a surface, its seam on the far side of `middle`.
gp_Ax3 frame_of(const Primitive& p, const Vec3& middle) {
  const Vec3 d = middle - p.point;
  const Vec3 across = d - d.dot(p.axis) * p.axis;
  const Vec3 x =
      across.norm() > 1e-6 * (1 + d.norm()) ? Vec3(-across.normalized()) : Vec3(rotation_onto_axis(p.axis).col(0));
  return {point(p.point), direction(p.axis), direction(x)};
}

/// The primitive as OpenCASCADE has it; its normal points to where distance() is positive.
Handle(Geom_Surface) surface_of(const Primitive& p, const Vec3& middle) {
  switch (p.kind) {
    case PrimitiveKind::cylinder:
      return new Geom_CylindricalSurface(frame_of(p, middle), p.radius);
    case PrimitiveKind::cone:
      return new Geom_ConicalSurface(frame_of(p, middle), p.half_angle, p.radius);
    case PrimitiveKind::sphere: {
      // Poles and seam away from the face.
      Primitive turned = p;
      const Vec3 d = middle - p.point;
      if (d.norm() > 1e-9 * p.radius) turned.axis = rotation_onto_axis(d.normalized()).col(0);
      return new Geom_SphericalSurface(frame_of(turned, middle), p.radius);
    }
    case PrimitiveKind::torus:
      return new Geom_ToroidalSurface(frame_of(p, middle), p.radius, p.tube);
    default:
      return new Geom_Plane(frame_of(p, middle));
  }
}

/// The nearest place near `q` on both surfaces; where they touch, as near to both as there is.
Vec3 onto_both(const Primitive& f, const Primitive& g, Vec3 q) {
  for (int step = 0; step < 12; ++step) {
    const double df = distance(f, q), dg = distance(g, q);
    const Vec3 nf = surface_normal(f, q), ng = surface_normal(g, q);
    const double c = nf.dot(ng), det = 1 - c * c;
    Vec3 move;
    if (det > 1e-4) {
      const double a = (-df + c * dg) / det, b = (-dg + c * df) / det;
      move = a * nf + b * ng;
    } else {
      move = -0.5 * (df * nf + dg * ng);
    }
    q += move;
    if (move.norm() < 1e-12) break;
  }
  return q;
}

/// A curve in space with its ends.
struct Trimmed {
  Handle(Geom_Curve) curve;
  double first = 0, last = 0;
};

class CurveFinder {
 public:
  /// The surfaces on either side; of a flat triangle of a free form none.
  CurveFinder(const Primitive* f, const Primitive* g, std::vector<Vec3> points, double tolerance)
      : points_(std::move(points)), tolerance_(tolerance) {
    for (const auto* s : {f, g})
      if (s) surfaces_.push_back(s);
  }

  Trimmed find() const {
    if (auto line = as_line()) return *line;
    if (auto circle = as_circle()) return *circle;
    return as_spline();
  }

 private:
  std::vector<const Primitive*> surfaces_;
  std::vector<Vec3> points_;
  double tolerance_;

  bool closed() const { return (points_.front() - points_.back()).norm() == 0; }

  double off(const Vec3& p) const {
    double most = 0;
    for (const auto* s : surfaces_) most = std::max(most, std::abs(distance(*s, p)));
    return most;
  }

  /// A place on the surfaces near `p`.
  Vec3 on_surfaces(const Vec3& p) const {
    if (surfaces_.empty()) return p;
    if (surfaces_.size() == 2) return onto_both(*surfaces_[0], *surfaces_[1], p);
    return p - distance(*surfaces_[0], p) * surface_normal(*surfaces_[0], p);
  }

  std::optional<Trimmed> as_line() const {
    if (closed()) return std::nullopt;
    const Vec3 a = points_.front(), b = points_.back(), along = (b - a).normalized();
    for (const auto& p : points_)
      if ((p - a - (p - a).dot(along) * along).norm() > tolerance_) return std::nullopt;
    for (int k = 1; k < 8; ++k)
      if (off(a + k / 8.0 * (b - a)) > tolerance_) return std::nullopt;
    return Trimmed{new Geom_Line(point(a), direction(along)), 0, (b - a).norm()};
  }

  /// Axes about which the border may be a circle.
  std::vector<std::pair<Vec3, Vec3>> axes() const {
    std::vector<std::pair<Vec3, Vec3>> found;
    for (const auto* s : surfaces_)
      if (s->kind == PrimitiveKind::cylinder || s->kind == PrimitiveKind::cone || s->kind == PrimitiveKind::torus)
        found.emplace_back(s->point, s->axis);
    for (const auto* s : surfaces_)
      for (const auto* t : surfaces_) {
        if (s == t || s->kind != PrimitiveKind::sphere) continue;
        if (t->kind == PrimitiveKind::plane) found.emplace_back(s->point, t->axis);
        if (t->kind == PrimitiveKind::sphere) found.emplace_back(s->point, (t->point - s->point).normalized());
      }
    // Round the tube of a torus.
    for (const auto* s : surfaces_)
      if (s->kind == PrimitiveKind::torus) {
        const Vec3 d = points_.front() - s->point, across = d - d.dot(s->axis) * s->axis;
        if (across.norm() > 0)
          found.emplace_back(s->point + s->radius * across.normalized(), s->axis.cross(across).normalized());
      }
    // Through three of the points.
    const std::size_t n = points_.size() - (closed() ? 1 : 0);
    if (n >= 3) {
      const Vec3 a = points_[0], b = points_[n / 3], c = points_[2 * n / 3];
      const Vec3 u = b - a, v = c - a, w = u.cross(v);
      if (w.norm() > 1e-6 * u.norm() * v.norm())
        found.emplace_back(a + (u.squaredNorm() * v.cross(w) - v.squaredNorm() * u.cross(w)) / (2 * w.squaredNorm()),
                           w.normalized());
    }
    return found;
  }

  std::optional<Trimmed> as_circle() const {
    for (const auto& [place, given] : axes()) {
      const double along = (points_.front() - place).dot(given);
      const Vec3 center = place + along * given, out = points_.front() - center;
      const double radius = out.norm();
      if (!(radius > tolerance_) || !std::isfinite(radius)) continue;
      const Vec3 x = out / radius;
      Vec3 axis = given, y = axis.cross(x);
      const auto angle = [&](const Vec3& p) {
        const double a = std::atan2((p - center).dot(y), (p - center).dot(x));
        return a < -1e-9 ? a + 2 * pi : std::max(a, 0.0);
      };
      // Towards the next point by the shorter way.
      if (angle(points_[1]) > pi) axis = -axis, y = -y;
      bool on = true;
      double before = 0;
      for (std::size_t k = 1; k < points_.size() && on; ++k) {
        const Vec3 d = points_[k] - center;
        on = std::abs(d.dot(axis)) <= tolerance_ && std::abs((d - d.dot(axis) * axis).norm() - radius) <= tolerance_;
        const double a = k + 1 == points_.size() && closed() ? 2 * pi : angle(points_[k]);
        on = on && a > before;
        before = a;
      }
      for (int k = 1; k < 16 && on; ++k) {
        const double a = before * k / 16;
        on = off(center + radius * (std::cos(a) * x + std::sin(a) * y)) <= tolerance_;
      }
      if (!on) continue;
      return Trimmed{new Geom_Circle(gp_Ax2(point(center), direction(axis), direction(x)), radius), 0, before};
    }
    return std::nullopt;
  }

  /// Through the corners and, between these, places on both surfaces.
  Trimmed as_spline() const {
    std::vector<Vec3> places;
    double total = 0;
    for (std::size_t k = 0; k + 1 < points_.size(); ++k) total += (points_[k + 1] - points_[k]).norm();
    for (std::size_t k = 0; k + 1 < points_.size(); ++k) {
      const double length = (points_[k + 1] - points_[k]).norm();
      const int pieces = std::clamp(static_cast<int>(std::ceil(16 * length / total)), 1, 16);
      for (int i = 0; i < pieces; ++i) {
        const Vec3 p = points_[k] + double(i) / pieces * (points_[k + 1] - points_[k]);
        places.push_back(i == 0 ? p : on_surfaces(p));
      }
    }
    if (!closed()) places.push_back(points_.back());
    const bool periodic = closed() && places.size() > 2;
    Handle(TColgp_HArray1OfPnt) list = new TColgp_HArray1OfPnt(1, static_cast<int>(places.size()));
    for (std::size_t k = 0; k < places.size(); ++k) list->SetValue(static_cast<int>(k) + 1, point(places[k]));
    GeomAPI_Interpolate interpolate(list, periodic, 1e-9);
    interpolate.Perform();
    if (!interpolate.IsDone()) return {};
    const Handle(Geom_BSplineCurve) curve = interpolate.Curve();
    return {Handle(Geom_Curve)(curve), curve->FirstParameter(), curve->LastParameter()};
  }
};

/// The body with a surface for every face: free form is flat triangle by triangle.
struct Prepared {
  FacedBody body;
  std::vector<std::uint32_t> given;  ///< of each face: its number in the body as it was given
};

Prepared prepared(const FacedBody& given) {
  Prepared result;
  result.body.mesh = given.mesh, result.body.face_of = given.face_of;
  std::vector<std::uint32_t> number(given.faces.size(), no_face);
  for (std::uint32_t t = 0; t < given.face_of.size(); ++t) {
    const auto f = given.face_of[t];
    if (given.faces[f].surface && number[f] != no_face) {
      result.body.face_of[t] = number[f];
      continue;
    }
    number[f] = static_cast<std::uint32_t>(result.body.faces.size());
    result.body.face_of[t] = number[f];
    result.given.push_back(f);
    AnalyticFace face = given.faces[f];
    if (!face.surface) {
      face.surface.emplace();
      face.surface->point = given.mesh.corner(t, 0), face.surface->axis = triangle_normal(given.mesh, t);
      face.hollow = false, face.flat = true;
    }
    result.body.faces.push_back(face);
  }
  return result;
}

/// Of the triangles that OpenCASCADE has made of the faces.
double drawn_area(const TopoDS_Shape& shape) {
  double area = 0;
  for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next()) {
    TopLoc_Location location;
    const Handle(Poly_Triangulation) mesh = BRep_Tool::Triangulation(TopoDS::Face(face.Current()), location);
    for (int t = 1; !mesh.IsNull() && t <= mesh->NbTriangles(); ++t) {
      int n[3];
      mesh->Triangle(t).Get(n[0], n[1], n[2]);
      const gp_XYZ a = mesh->Node(n[0]).XYZ();
      area += 0.5 * (mesh->Node(n[1]).XYZ() - a).Crossed(mesh->Node(n[2]).XYZ() - a).Modulus();
    }
  }
  return area;
}

class FacedBuilder {
 public:
  FacedBuilder(const FacedBody& body, double tolerance) : body_(body), tolerance_(tolerance) {}

  /// Faces that cannot be built; none: the shape is there.
  std::vector<std::uint32_t> build() {
    measure();
    const FaceBorders borders = face_borders(body_);
    make_edges(borders);
    std::vector<std::uint32_t> bad;
    faces_.resize(body_.faces.size());
    for (std::uint32_t f = 0; f < faces_.size(); ++f)
      if (!make_face(f, borders.loops[f]) || missed_[f]) bad.push_back(f);
    return bad;
  }

  /// Faces that share a border.
  const std::vector<std::pair<std::uint32_t, std::uint32_t>>& neighbours() const { return neighbours_; }

  /// All faces put together and mended; empty if that fails. Bad faces are named.
  TopoDS_Shape assembled(std::vector<std::uint32_t>& bad) {
    DisjointSets sets(faces_.size());
    for (const auto& [f, g] : neighbours_) sets.unite(f, g);
    std::map<std::uint32_t, TopoDS_Shell> shells;  // by the least of their faces
    for (std::uint32_t f = 0; f < faces_.size(); ++f) {
      TopoDS_Shell& shell = shells[sets.root(f)];
      if (shell.IsNull()) builder_.MakeShell(shell);
      builder_.Add(shell, faces_[f]);
    }
    std::map<std::uint32_t, ClosedShell> closed;
    for (auto& [root, shell] : shells) shell.Closed(true), closed[root].shell = &shell;
    for (std::size_t t = 0; t < body_.face_of.size(); ++t) {
      ClosedShell& shell = closed.at(sets.root(body_.face_of[t]));
      const Vec3 a = body_.mesh.corner(t, 0), b = body_.mesh.corner(t, 1), c = body_.mesh.corner(t, 2);
      shell.volume += a.dot(b.cross(c)) / 6;
      for (const auto& p : {a, b, c}) shell.bounds.add(p);
    }
    std::vector<ClosedShell> list;
    for (const auto& [root, shell] : closed) list.push_back(shell);
    ShapeFix_Shape fix(solids_of(list));
    fix.SetPrecision(1e-6), fix.SetMaxTolerance(tolerance_);
    // Faces are turned as the triangles are; to look at that again takes time by the square of their number.
    fix.FixSolidTool()->FixShellTool()->FixOrientationMode() = 0, fix.FixSolidTool()->FixShellOrientationMode() = 0;
    fix.FixShellTool()->FixOrientationMode() = 0;
    fix.Perform();
    const TopoDS_Shape fixed = fix.Shape();
    std::vector<std::uint32_t> order;  // of the faces in the body, by number
    TopTools_DataMapOfShapeInteger number;
    for (std::uint32_t f = 0; f < faces_.size(); ++f)
      if (const TopoDS_Shape now = fix.Context()->Apply(faces_[f]); now.IsNull() || now.ShapeType() != TopAbs_FACE)
        bad.push_back(f);
      else
        number.Bind(now, static_cast<int>(f));
    if (!bad.empty()) return fixed;
    for (TopExp_Explorer face(fixed, TopAbs_FACE); face.More(); face.Next())
      order.push_back(static_cast<std::uint32_t>(number.Find(face.Current())));
    bad = wrong_in(fixed, order);
    if (!bad.empty()) return fixed;
    const auto read = as_read(fixed);
    if (!read) return {};
    for (const TopoDS_Shape& shape : *read) {
      const auto wrong = wrong_in(shape, order);
      bad.insert(bad.end(), wrong.begin(), wrong.end());
    }
    return fixed;
  }

 private:
  const FacedBody& body_;
  double tolerance_;
  BRep_Builder builder_;
  std::vector<double> area_, perimeter_;
  std::vector<std::uint8_t> missed_;  // of each face: it does not meet a neighbour
  std::vector<Vec3> middle_;
  std::vector<TopoDS_Edge> edges_;
  std::vector<TopoDS_Face> faces_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> neighbours_;
  std::vector<TopoDS_Vertex> vertices_;

  /// Faces of a shape that are invalid or of another area than their triangles; all round ones if some are missing.
  std::vector<std::uint32_t> wrong_in(const TopoDS_Shape& shape, const std::vector<std::uint32_t>& order) const {
    // Readers draw faces by triangles: what they cannot draw is as bad as what is not there.
    const double chords = 5 * tolerance_;
    BRepMesh_IncrementalMesh(shape, chords, false, 0.35, false);
    std::vector<std::uint32_t> wrong;
    std::size_t k = 0;
    for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next(), ++k) {
      if (k >= order.size()) continue;
      const auto f = order[k];
      const TopoDS_Shape& now = face.Current();
      const double exact = area_of(now), drawn = drawn_area(now);
      const bool right = std::abs(exact - area_[f]) <= wrong_area * area_[f] + 50 * tolerance_ * perimeter_[f];
      const bool drawable = std::abs(drawn - exact) <= 0.2 * wrong_area * exact + chords * perimeter_[f];
      if (!right || !drawable || !BRepCheck_Analyzer(now).IsValid()) wrong.push_back(f);
    }
    BRepTools::Clean(shape);
    if (k == order.size()) return wrong;
    wrong.clear();
    for (const auto f : order)
      if (!body_.faces[f].flat && body_.faces[f].surface->kind != PrimitiveKind::plane) wrong.push_back(f);
    return wrong;
  }

  void measure() {
    const std::size_t count = body_.faces.size();
    missed_.assign(count, 0);
    area_.assign(count, 0), perimeter_.assign(count, 0), middle_.assign(count, Vec3::Zero());
    for (std::size_t t = 0; t < body_.face_of.size(); ++t) {
      const Vec3 a = body_.mesh.corner(t, 0), b = body_.mesh.corner(t, 1), c = body_.mesh.corner(t, 2);
      const double area = 0.5 * (b - a).cross(c - a).norm();
      area_[body_.face_of[t]] += area, middle_[body_.face_of[t]] += area / 3 * (a + b + c);
    }
    for (std::size_t f = 0; f < count; ++f)
      if (area_[f] > 0) middle_[f] /= area_[f];
  }

  /// Two faces do not meet: the smaller one, or the one that is no flat triangle, is to blame.
  void miss(std::uint32_t f, std::uint32_t g) {
    const bool first = body_.faces[g].flat || (!body_.faces[f].flat && area_[f] < area_[g]);
    missed_[first ? f : g] = 1;
  }

  TopoDS_Vertex& vertex(std::uint32_t v) {
    TopoDS_Vertex& made = vertices_[v];
    if (made.IsNull()) builder_.MakeVertex(made, point(body_.mesh.vertices[v]), tolerance_);
    return made;
  }

  void make_edges(const FaceBorders& borders) {
    vertices_.resize(body_.mesh.vertices.size());
    for (const auto& curve : borders.curves) {
      std::vector<Vec3> points;
      for (const auto v : curve.vertices) points.push_back(body_.mesh.vertices[v]);
      for (std::size_t k = 0; k + 1 < points.size(); ++k) {
        const double length = (points[k + 1] - points[k]).norm();
        perimeter_[curve.left] += length, perimeter_[curve.right] += length;
      }
      neighbours_.emplace_back(curve.left, curve.right);
      const AnalyticFace &left = body_.faces[curve.left], &right = body_.faces[curve.right];
      const Trimmed trimmed =
          CurveFinder(left.flat ? nullptr : &*left.surface, right.flat ? nullptr : &*right.surface, points, tolerance_)
              .find();
      TopoDS_Edge edge;
      if (!trimmed.curve.IsNull()) {
        double off = 0.1 * tolerance_;
        for (int k = 0; k <= 16; ++k) {
          const gp_Pnt at = trimmed.curve->Value(trimmed.first + k / 16.0 * (trimmed.last - trimmed.first));
          for (const auto* face : {&left, &right})
            off = std::max(off, std::abs(distance(*face->surface, Vec3(at.X(), at.Y(), at.Z()))));
        }
        if (off > widest_gap * tolerance_) miss(curve.left, curve.right);
        builder_.MakeEdge(edge, trimmed.curve, 1.2 * off);
        builder_.Add(edge, vertex(curve.vertices.front()).Oriented(TopAbs_FORWARD));
        builder_.Add(edge, vertex(curve.vertices.back()).Oriented(TopAbs_REVERSED));
        builder_.Range(edge, trimmed.first, trimmed.last);
      }
      edges_.push_back(edge);
    }
  }

  bool make_face(std::uint32_t f, const std::vector<std::vector<BorderUse>>& loops) {
    const AnalyticFace& given = body_.faces[f];
    TopoDS_Face& face = faces_[f];
    builder_.MakeFace(face, surface_of(*given.surface, middle_[f]), tolerance_);
    if (loops.empty()) return false;
    for (const auto& loop : loops) {
      TopoDS_Wire wire;
      builder_.MakeWire(wire);
      // Of a hollow face the wires run as the surface itself is seen, and the face as a whole is turned.
      std::vector<BorderUse> uses = loop;
      if (given.hollow) {
        std::reverse(uses.begin(), uses.end());
        for (auto& use : uses) use.forward = !use.forward;
      }
      for (const auto& use : uses) {
        const TopoDS_Edge& edge = edges_[use.curve];
        if (edge.IsNull()) return false;
        builder_.Add(wire, edge.Oriented(use.forward ? TopAbs_FORWARD : TopAbs_REVERSED));
      }
      wire.Closed(true);
      builder_.Add(face, wire);
    }
    if (given.hollow) face.Reverse();
    return true;
  }
};

}  // namespace

TopoDS_Shape brep_of_faces(FacedBody& body, double tolerance) {
  if (!topology(body.mesh).closed()) return {};
  for (int round = 0; round < most_rounds; ++round) {
    const Prepared ready = prepared(body);
    std::vector<std::uint32_t> bad;
    TopoDS_Shape shape;
    FacedBuilder builder(ready.body, tolerance);
    try {
      bad = builder.build();
      if (bad.empty()) shape = builder.assembled(bad);
    } catch (const Standard_Failure&) {
      return {};
    }
    if (bad.empty()) return shape;
    // A triangle of a free form is bad for what it borders on.
    std::vector<std::uint8_t> given_up(ready.body.faces.size(), 0);
    for (const auto f : bad) given_up[f] = 1;
    for (const auto& [left, right] : builder.neighbours())
      for (const auto& [f, g] : {std::pair(left, right), std::pair(right, left)})
        if (given_up[f] == 1 && ready.body.faces[f].flat && !ready.body.faces[g].flat) given_up[g] = 2;
    bool changed = false;
    for (std::uint32_t f = 0; f < given_up.size(); ++f)
      if (auto& surface = body.faces[ready.given[f]].surface; given_up[f] && surface) surface.reset(), changed = true;
    if (!changed) return {};
  }
  return {};
}

}  // namespace partscribe::codegen
