#include "verify/scl/scl_geometry.h"

#include <BRepAlgoAPI_Common.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_GTransform.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepClass3d_SolidClassifier.hxx>
#include <BRepGProp.hxx>
#include <BRepLib.hxx>
#include <BRepOffsetAPI_DraftAngle.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepTools_WireExplorer.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <GProp_GProps.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Message_ProgressIndicator.hxx>
#include <ShapeFix_Face.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_ListOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <cmath>
#include <gp_Ax2.hxx>
#include <gp_GTrsf.hxx>
#include <gp_Pln.hxx>

#include "core/number.h"
#include "verify/scl/scl_shape.h"

namespace partscribe::verify {
namespace {

gp_Pnt pnt(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
gp_Dir dir(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
Vec3 vec3(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }

/// Lets the kernel's long operations stop.
class Interrupt : public Message_ProgressIndicator {
 public:
  explicit Interrupt(const SclStop& stop) : stop_(stop) {}
  Standard_Boolean UserBreak() override { return stop_ && stop_(); }
  void Show(const Message_ProgressScope&, const Standard_Boolean) override {}

 private:
  const SclStop& stop_;
};

Error refuse(const std::string& what) { return bad_input(what); }

Error failure(const char* what, const Standard_Failure& cause) {
  return bad_input(std::string(what) + ": " +
                   (cause.GetMessageString() ? cause.GetMessageString() : "geometry kernel failed"));
}

SclGeometryPtr made(SclGeometryKind kind, const TopoDS_Shape& shape, bool solid, bool natural = false) {
  auto geometry = std::make_shared<SclGeometry>();
  geometry->kind = kind;
  geometry->shape = std::make_shared<const TopoDS_Shape>(shape);
  geometry->solid = solid;
  geometry->natural = natural;
  return geometry;
}

bool has_solid(const TopoDS_Shape& shape) { return TopExp_Explorer(shape, TopAbs_SOLID).More(); }

double volume_of(const TopoDS_Shape& shape) {
  GProp_GProps properties;
  BRepGProp::VolumeProperties(shape, properties);
  return properties.Mass();
}

TopoDS_Shape outward(TopoDS_Shape shape) {
  if (shape.ShapeType() == TopAbs_SOLID) {
    TopoDS_Solid solid = TopoDS::Solid(shape);
    BRepLib::OrientClosedSolid(solid);
    return solid;
  }
  if (volume_of(shape) < 0) shape.Reverse();
  return shape;
}

/// A plane face with the first wire as its outline and the others as holes.
Result<TopoDS_Face> plane_face(const gp_Pln& plane, const std::vector<TopoDS_Wire>& wires) {
  BRepBuilderAPI_MakeFace maker(plane, wires[0], true);
  if (!maker.IsDone()) return refuse("the outline does not bound a plane face");
  for (std::size_t i = 1; i < wires.size(); ++i) maker.Add(wires[i]);
  ShapeFix_Face fix(maker.Face());
  fix.FixOrientation();
  const TopoDS_Face face = fix.Face();
  if (!BRepCheck_Analyzer(face).IsValid()) return refuse("the profiles cross themselves or each other");
  return face;
}

double largest_coordinate(const TopoDS_Shape& shape, int axis, double sign) {
  double result = -1e300;
  for (TopExp_Explorer e(shape, TopAbs_VERTEX); e.More(); e.Next())
    result = std::max(result, sign * vec3(BRep_Tool::Pnt(TopoDS::Vertex(e.Current())))[axis]);
  return result;
}

/// Checks that all corners of a profile lie in the plane where coordinate `axis` is 0.
bool in_plane(const TopoDS_Shape& wire, int axis) {
  return std::max(largest_coordinate(wire, axis, 1), largest_coordinate(wire, axis, -1)) <= scl_join;
}

bool closed_wire(const TopoDS_Shape& wire) { return wire.Closed(); }

struct Ends {
  Vec3 first, last;
};
Ends ends_of(const TopoDS_Shape& wire) {
  std::vector<TopoDS_Edge> edges;
  for (TopExp_Explorer e(wire, TopAbs_EDGE); e.More(); e.Next()) edges.push_back(TopoDS::Edge(e.Current()));
  return {vec3(BRep_Tool::Pnt(TopExp::FirstVertex(edges.front(), true))),
          vec3(BRep_Tool::Pnt(TopExp::LastVertex(edges.back(), true)))};
}

/// The wire and straight lines from its ends to the z axis and along it.
Result<TopoDS_Wire> closed_to_axis(const SclGeometryPtr& profile) {
  if (closed_wire(*profile->shape)) return TopoDS::Wire(*profile->shape);
  const auto [first, last] = ends_of(*profile->shape);
  if (std::abs(first.z() - last.z()) <= scl_join) return refuse("expected an open profile whose ends differ along z");
  std::vector<SclCorner> corners;
  corners.push_back({Vec3(0, 0, first.z()), nullptr});
  for (TopExp_Explorer e(*profile->shape, TopAbs_EDGE); e.More(); e.Next())
    corners.push_back({Vec3::Zero(), made(SclGeometryKind::curve, e.Current(), false)});
  corners.push_back({Vec3(0, 0, last.z()), nullptr});
  corners.push_back({Vec3(0, 0, first.z()), nullptr});
  auto closed = scl_profile(corners);
  if (!closed.ok()) return closed.error();
  return TopoDS::Wire(*(*closed)->shape);
}

gp_Trsf rigid(const SclTransform& t) {
  gp_Trsf result;
  const auto& m = t.linear;
  result.SetValues(m(0, 0), m(0, 1), m(0, 2), t.translation.x(), m(1, 0), m(1, 1), m(1, 2), t.translation.y(), m(2, 0),
                   m(2, 1), m(2, 2), t.translation.z());
  return result;
}

/// Whether the linear part is a rotation, mirror or equal scaling of all directions.
bool similarity(const Mat3& m) {
  const Mat3 square = m.transpose() * m;
  return (square - Mat3::Identity() * square(0, 0)).norm() <= 1e-12 * square(0, 0);
}

}  // namespace

SclMade scl_box(const Vec3& o, const Vec3& a, const Vec3& b, const Vec3& c) {
  if (std::abs(a.dot(b.cross(c))) <= 1e-12 * a.norm() * b.norm() * c.norm() || a.norm() * b.norm() * c.norm() == 0)
    return refuse("the three vectors of a box lie in a plane");
  auto shell = scl_facets({{o, o + b, o + a + b, o + a},
                           {o + c, o + c + a, o + c + a + b, o + c + b},
                           {o, o + a, o + a + c, o + c},
                           {o + b, o + b + c, o + a + b + c, o + a + b},
                           {o, o + c, o + b + c, o + b},
                           {o + a, o + a + b, o + a + b + c, o + a + c}});
  if (!shell.ok()) return shell;
  auto box = std::make_shared<SclGeometry>(**shell);
  box->kind = SclGeometryKind::primitive;
  return SclGeometryPtr(box);
}

SclMade scl_wedge(const Vec3& o, const Vec3& a, const Vec3& b, const Vec3& c) {
  if (std::abs(a.dot(b.cross(c))) <= 1e-12 * a.norm() * b.norm() * c.norm() || a.norm() * b.norm() * c.norm() == 0)
    return refuse("the three vectors of a wedge lie in a plane");
  auto shell = scl_facets({{o, o + b, o + a},
                           {o + c, o + c + a, o + c + b},
                           {o, o + a, o + a + c, o + c},
                           {o, o + c, o + b + c, o + b},
                           {o + a, o + b, o + b + c, o + a + c}});
  if (!shell.ok()) return shell;
  auto wedge = std::make_shared<SclGeometry>(**shell);
  wedge->kind = SclGeometryKind::primitive;
  return SclGeometryPtr(wedge);
}

SclMade scl_cylinder(const Vec3& base, const Vec3& axis, double radius) {
  if (!(axis.norm() > scl_join)) return refuse("the axis of a cylinder has no length");
  if (!(radius > scl_join)) return refuse("expected a positive radius of a cylinder, found " + print_number(radius));
  return made(SclGeometryKind::primitive,
              BRepPrimAPI_MakeCylinder(gp_Ax2(pnt(base), dir(axis)), radius, axis.norm()).Shape(), true);
}

SclMade scl_unit_sphere() { return made(SclGeometryKind::primitive, BRepPrimAPI_MakeSphere(1.0).Shape(), true); }

SclMade scl_shell_of(const SclGeometryPtr& geometry) {
  if (geometry->kind == SclGeometryKind::shell) return geometry;
  if (geometry->kind != SclGeometryKind::primitive)
    return refuse(std::string("expected a primitive, found ") + name_of(geometry->kind));
  auto shell = std::make_shared<SclGeometry>(*geometry);
  shell->kind = SclGeometryKind::shell;
  return SclGeometryPtr(shell);
}

SclMade scl_revolved(const std::vector<SclGeometryPtr>& profiles, double angle) {
  if (profiles.empty()) return refuse("expected a profile to turn");
  if (!(angle > 0) || angle > 2 * pi + 1e-9)
    return refuse("expected a turn above 0 and of 360 degrees at most, found " + print_degrees(angle));
  try {
    std::vector<TopoDS_Wire> wires;
    for (const auto& profile : profiles) {
      if (!in_plane(*profile->shape, 1)) return refuse("expected a profile in the plane y = 0");
      if (largest_coordinate(*profile->shape, 0, -1) > scl_join)
        return refuse("expected a profile with x >= 0, found a corner beyond the axis");
      auto wire = closed_to_axis(profile);
      if (!wire.ok()) return wire.error();
      wires.push_back(*wire);
    }
    auto face = plane_face(gp_Pln(gp_Pnt(0, 0, 0), gp_Dir(0, 1, 0)), wires);
    if (!face.ok()) return face.error();
    const gp_Ax1 axis(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1));
    BRepPrimAPI_MakeRevol maker =
        angle > 2 * pi - 1e-9 ? BRepPrimAPI_MakeRevol(*face, axis) : BRepPrimAPI_MakeRevol(*face, axis, angle);
    if (!maker.IsDone() || !has_solid(maker.Shape())) return refuse("the profile does not turn into a solid");
    return made(SclGeometryKind::shell, outward(maker.Shape()), true);
  } catch (const Standard_Failure& f) {
    return failure("the profile does not turn into a solid", f);
  }
}

namespace {

/// Closed profiles in the plane z = 0, moved along z from one height to another.
Result<TopoDS_Shape> prism(const std::vector<SclGeometryPtr>& profiles, double from, double to) {
  if (profiles.empty()) return refuse("expected a profile to extrude");
  if (!(std::abs(to - from) > scl_join)) return refuse("expected a height other than 0");
  std::vector<TopoDS_Wire> wires;
  for (const auto& profile : profiles) {
    if (!closed_wire(*profile->shape)) return refuse("expected a closed profile, found one whose ends do not meet");
    if (!in_plane(*profile->shape, 2)) return refuse("expected a profile in the plane z = 0");
    wires.push_back(TopoDS::Wire(*profile->shape));
  }
  auto face = plane_face(gp_Pln(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), wires);
  if (!face.ok()) return face.error();
  gp_Trsf lifted;
  lifted.SetTranslation(gp_Vec(0, 0, from));
  const TopoDS_Shape base = from == 0 ? *face : BRepBuilderAPI_Transform(*face, lifted, true).Shape();
  BRepPrimAPI_MakePrism maker(base, gp_Vec(0, 0, to - from));
  if (!maker.IsDone() || !has_solid(maker.Shape())) return refuse("the profile does not extrude into a solid");
  return maker.Shape();
}

}  // namespace

SclMade scl_extruded(const std::vector<SclGeometryPtr>& profiles, double height) {
  try {
    auto body = prism(profiles, 0, height);
    if (!body.ok()) return body.error();
    return made(SclGeometryKind::shell, outward(*body), true);
  } catch (const Standard_Failure& f) {
    return failure("the profile does not extrude into a solid", f);
  }
}

SclMade scl_drafted(const std::vector<SclGeometryPtr>& profiles, double below, double height, double draft) {
  if (!(below >= 0)) return refuse("expected no negative length below the profiles, found " + print_number(below));
  if (!(height > 0)) return refuse("expected a positive height, found " + print_number(height));
  if (!(std::abs(draft) < pi / 2)) return refuse("expected a draft below 90 degrees, found " + print_degrees(draft));
  try {
    auto body = prism(profiles, -below, height);
    if (!body.ok()) return body.error();
    if (draft == 0) return made(SclGeometryKind::shell, outward(*body), true);
    // Every wall is turned about the line in which it crosses z = 0.
    BRepOffsetAPI_DraftAngle lean(*body);
    for (TopExp_Explorer e(*body, TopAbs_FACE); e.More(); e.Next()) {
      const TopoDS_Face& face = TopoDS::Face(e.Current());
      const bool cap = largest_coordinate(face, 2, 1) + largest_coordinate(face, 2, -1) < scl_join;
      if (cap) continue;
      lean.Add(face, gp_Dir(0, 0, 1), draft, gp_Pln(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)));
      if (!lean.AddDone()) return refuse("the walls cannot lean that way: arcs have to join tangentially");
    }
    lean.Build();
    if (!lean.IsDone() || !has_solid(lean.Shape()) || !BRepCheck_Analyzer(lean.Shape()).IsValid())
      return refuse("the walls cannot lean that far: an edge or an arc vanishes");
    return made(SclGeometryKind::shell, outward(lean.Shape()), true);
  } catch (const Standard_Failure& f) {
    return failure("the walls cannot lean that way", f);
  }
}

SclMade scl_swept(const SclGeometryPtr& surface, const Vec3& direction) {
  if (!surface->shape) return refuse("expected a surface without a border, to move it");
  if (!(direction.norm() > scl_join)) return refuse("expected a direction other than 0");
  try {
    BRepPrimAPI_MakePrism maker(*surface->shape, gp_Vec(direction.x(), direction.y(), direction.z()));
    if (!maker.IsDone() || !has_solid(maker.Shape())) return refuse("the surface leaves no solid behind as it moves");
    return made(SclGeometryKind::shell, outward(maker.Shape()), true);
  } catch (const Standard_Failure& f) {
    return failure("the surface leaves no solid behind as it moves", f);
  }
}

SclMade scl_sewn(const std::vector<SclGeometryPtr>& surfaces) {
  if (surfaces.empty()) return refuse("expected surfaces to join");
  if (std::any_of(surfaces.begin(), surfaces.end(), [](const auto& s) { return !s->trimmed.empty(); }))
    return trimmed_shell(surfaces);
  bool flat = true;  // all bilinear: then facets say the same, and far more simply
  for (const auto& s : surfaces) {
    if (s->kind != SclGeometryKind::surface) return refuse(std::string("expected surfaces, found ") + name_of(s->kind));
    const auto spline = Handle(Geom_BSplineSurface)::DownCast(BRep_Tool::Surface(TopoDS::Face(*s->shape)));
    flat = flat && !spline.IsNull() && spline->UDegree() == 1 && spline->VDegree() == 1;
  }
  try {
    if (flat) {
      std::vector<std::vector<Vec3>> facets;
      for (const auto& s : surfaces) {
        const auto mesh = surface_mesh(*s, 1e-3).mesh;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
          facets.push_back({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)});
      }
      return scl_facets(facets);
    }
    BRepBuilderAPI_Sewing sewing(1e-5);
    for (const auto& s : surfaces) sewing.Add(*s->shape);
    sewing.Perform();
    TopoDS_Shape sewn = sewing.SewedShape();
    TopoDS_Shell shell;
    BRep_Builder builder;
    builder.MakeShell(shell);
    if (TopExp_Explorer shells(sewn, TopAbs_SHELL); shells.More()) {
      shell = TopoDS::Shell(shells.Current());
      shells.Next();
      if (shells.More()) return refuse("the surfaces do not meet along their edges");
    } else {
      for (TopExp_Explorer faces(sewn, TopAbs_FACE); faces.More(); faces.Next()) builder.Add(shell, faces.Current());
    }
    const bool natural = surfaces.size() == 1 && surfaces[0]->natural;
    if (!BRep_Tool::IsClosed(shell)) return made(SclGeometryKind::shell, shell, false, natural);
    TopoDS_Solid solid;
    builder.MakeSolid(solid);
    builder.Add(solid, shell);
    return made(SclGeometryKind::shell, outward(solid), true, natural);
  } catch (const Standard_Failure& f) {
    return failure("the surfaces cannot be joined", f);
  }
}

SclMade scl_combined(SclOperation operation, const SclGeometryPtr& a, const SclGeometryPtr& b, const SclStop& stop) {
  for (const auto& g : {a, b})
    if (g->kind != SclGeometryKind::shell && g->kind != SclGeometryKind::surface)
      return refuse(std::string("expected shells to combine, found ") + name_of(g->kind) +
                    (g->kind == SclGeometryKind::primitive ? " (makeGeom makes its shell)" : ""));
  auto first = brep_of(*a), second = brep_of(*b);
  if (!first.ok()) return first.error();
  if (!second.ok()) return second.error();
  const bool solid = a->solid && b->solid;
  if (operation == SclOperation::unite && !solid) return refuse("expected closed shells to unite, found an open one");
  if (!b->solid) return refuse("expected a closed shell as the second operand, found an open one");
  try {
    TopTools_ListOfShape arguments, tools;
    arguments.Append(*first);
    tools.Append(*second);
    TopoDS_Shape result;
    // Faces of fitted parts may coincide only nearly; the second try unites what lies within its fuzz.
    for (const double fuzz : {0.0, 1e-5}) {
      BRepAlgoAPI_BooleanOperation op;
      op.SetOperation(operation == SclOperation::unite      ? BOPAlgo_FUSE
                      : operation == SclOperation::subtract ? BOPAlgo_CUT
                                                            : BOPAlgo_COMMON);
      op.SetArguments(arguments);
      op.SetTools(tools);
      op.SetNonDestructive(true);
      if (fuzz > 0) op.SetFuzzyValue(fuzz);
      Handle(Interrupt) interrupt = new Interrupt(stop);
      op.Build(interrupt->Start());
      if (stop && stop()) return Error{"the combination of two shells was stopped", ErrorKind::stopped};
      if (op.HasErrors()) continue;
      result = op.Shape();
      if (!result.IsNull() && BRepCheck_Analyzer(result).IsValid()) break;
    }
    if (result.IsNull()) return refuse("the two shells cannot be combined");
    const TopAbs_ShapeEnum wanted = solid ? TopAbs_SOLID : TopAbs_FACE;
    TopoDS_Compound kept;
    BRep_Builder builder;
    builder.MakeCompound(kept);
    int count = 0;
    for (TopExp_Explorer e(result, wanted); e.More(); e.Next(), ++count) builder.Add(kept, e.Current());
    if (count == 0) return refuse("the combination of the two shells leaves nothing");
    return made(SclGeometryKind::shell, kept, solid);
  } catch (const Standard_Failure& f) {
    return failure("the two shells cannot be combined", f);
  }
}

SclMade scl_transformed(const SclGeometryPtr& geometry, const SclTransform& transform) {
  const double determinant = transform.linear.determinant();
  if (!(std::abs(determinant) > 1e-18)) return refuse("the transformation flattens the object");
  auto moved = std::make_shared<SclGeometry>(*geometry);
  if (geometry->kind == SclGeometryKind::group) {
    for (auto& member : moved->members) {
      auto m = scl_transformed(member, transform);
      if (!m.ok()) return m;
      member = *m;
    }
    return SclGeometryPtr(moved);
  }
  if (!geometry->trimmed.empty()) {
    for (auto& surface : moved->trimmed) {
      for (Vec3& p : surface.surface.points) p = transform * p;
      if (determinant < 0) surface = turned_over(surface);
    }
    return SclGeometryPtr(moved);
  }
  if (!geometry->shape) {
    for (auto& p : moved->corners) p = transform * p;
    if (determinant < 0)
      for (auto& facet : moved->facets) std::reverse(facet.begin(), facet.end());
    return SclGeometryPtr(moved);
  }
  try {
    TopoDS_Shape shape;
    if (similarity(transform.linear)) {
      shape = BRepBuilderAPI_Transform(*geometry->shape, rigid(transform), true).Shape();
    } else {
      gp_GTrsf general;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) general.SetValue(i + 1, j + 1, transform.linear(i, j));
        general.SetValue(i + 1, 4, transform.translation[i]);
      }
      shape = BRepBuilderAPI_GTransform(*geometry->shape, general, true).Shape();
    }
    if (geometry->solid && determinant < 0) shape = outward(shape);
    moved->shape = std::make_shared<const TopoDS_Shape>(shape);
    return SclGeometryPtr(moved);
  } catch (const Standard_Failure& f) {
    return failure("the object cannot be transformed", f);
  }
}

SclMade scl_group(std::vector<SclGeometryPtr> members) {
  if (members.empty()) return refuse("expected objects to group, found none");
  auto group = std::make_shared<SclGeometry>();
  group->kind = SclGeometryKind::group;
  group->leaves = 0;
  for (const auto& m : members) group->leaves += m->leaves;
  if (group->leaves > 100'000)
    return refuse("expected at most 100000 objects in a group, found " + std::to_string(group->leaves));
  group->members = std::move(members);
  return SclGeometryPtr(group);
}

}  // namespace partscribe::verify
