#include "codegen/exchange/brep.h"

#include <BRepAlgoAPI_Common.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <Geom_Surface.hxx>
#include <Poly_Triangulation.hxx>
#include <ShapeUpgrade_UnifySameDomain.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopTools_ListOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <gp_Trsf.hxx>
#include <map>

#include "codegen/exchange/brep_faces.h"
#include "codegen/exchange/brep_shapes.h"
#include "core/ensure.h"
#include "core/number.h"
#include "model/distance/distance.h"
#include "model/lower/lower.h"
#include "model/tri_faces.h"

namespace partscribe::codegen {
namespace {

// More faces than this are a mesh, whose facets nobody wants to name.
constexpr int most_named_faces = 1000;

// Muted colours that stay apart from their neighbours; one per object, in turn.
constexpr std::array<std::array<double, 3>, 8> palette = {{{0.70, 0.74, 0.80},
                                                           {0.86, 0.60, 0.36},
                                                           {0.45, 0.66, 0.52},
                                                           {0.56, 0.52, 0.74},
                                                           {0.80, 0.72, 0.42},
                                                           {0.42, 0.62, 0.76},
                                                           {0.76, 0.48, 0.52},
                                                           {0.60, 0.60, 0.60}}};

TopoDS_Shape moved(const TopoDS_Shape& shape, const Pose& pose) {
  if (pose.rotation == Mat3::Identity() && pose.translation == Vec3::Zero()) return shape;
  const Mat3& r = pose.rotation;
  const Vec3& t = pose.translation;
  gp_Trsf motion;
  motion.SetValues(r(0, 0), r(0, 1), r(0, 2), t.x(), r(1, 0), r(1, 1), r(1, 2), t.y(), r(2, 0), r(2, 1), r(2, 2),
                   t.z());
  return BRepBuilderAPI_Transform(shape, motion, true).Shape();
}

double volume_of(const TopoDS_Shape& shape) {
  GProp_GProps properties;
  BRepGProp::VolumeProperties(shape, properties);
  return properties.Mass();
}

/// Faces that lie on one surface become one, if that leaves the body as it was.
TopoDS_Shape unified(const TopoDS_Shape& shape) {
  try {
    ShapeUpgrade_UnifySameDomain unify(shape, true, true, false);
    unify.Build();
    const TopoDS_Shape& result = unify.Shape();
    const double before = volume_of(shape), after = volume_of(result);
    if (BRepCheck_Analyzer(result).IsValid() && std::abs(after - before) <= 1e-9 * std::abs(before)) return result;
  } catch (const Standard_Failure&) {
  }
  return shape;
}

template <class Operation>
TopoDS_Shape combined(const TopTools_ListOfShape& first, const TopTools_ListOfShape& others) {
  Operation operation;
  operation.SetArguments(first);
  operation.SetTools(others);
  operation.Build();
  if (!operation.IsDone() || operation.HasErrors()) return {};
  return operation.Shape();
}

/// A boolean's result without the compound around a single solid.
TopoDS_Shape unwrapped(const TopoDS_Shape& shape) {
  if (shape.IsNull()) return shape;
  TopTools_IndexedMapOfShape solids;
  TopExp::MapShapes(shape, TopAbs_SOLID, solids);
  return solids.Extent() == 1 ? solids(1) : shape;
}

class Builder {
 public:
  explicit Builder(const Model& model) : model_(model), values_(values_of(model)) {}

  /// The part in its own frame.
  Result<TopoDS_Shape> build_part(Context& context) {
    for (const Object& object : model_.objects) {
      if (context.cancelled) return Error{"stopped while building '" + object.name + "'", ErrorKind::stopped};
      TopoDS_Shape shape;
      std::string reason = "OpenCASCADE could not build it";
      try {
        shape = std::visit([&](const auto& s) { return build(s); }, evaluate(object.shape, values_));
      } catch (const Standard_Failure& failure) {
        shape.Nullify();
        reason = std::string("OpenCASCADE says: ") + failure.GetMessageString();
      }
      if (shape.IsNull()) {
        return bad_input("object '" + object.name + "': expected a " + std::string(kind_of(object.shape)) +
                         " with an exact boundary, but " + reason);
      }
      built_[object.name] = moved(shape, evaluate(object.frame, values_));
    }
    return built_.at(model_.objects.back().name);
  }

  double error() const { return error_; }

 private:
  template <class S>
  TopoDS_Shape build(const S& s) {
    return brep_of(s);
  }
  template <LoweredAway S>
  TopoDS_Shape build(const S&) {
    ensure(false, "features are lowered before");
    return {};
  }
  /// By the surfaces of its faces where these close, else triangle by triangle.
  TopoDS_Shape build(const TriSurfaceOf<double>& s) {
    if (s.faces.empty()) return brep_of(s);
    FacedBody body;
    for (const auto& v : s.vertices) body.mesh.vertices.emplace_back(v[0], v[1], v[2]);
    body.mesh.triangles = s.triangles, body.face_of = faces_of_triangles(s);
    for (const auto& face : s.faces) body.faces.push_back({surface_of(face), face.hollow});
    const TopoDS_Shape shape = brep_of_faces(body, 0.02 * model_.tolerance);
    return shape.IsNull() || !BRepCheck_Analyzer(shape).IsValid() ? brep_of(s) : shape;
  }
  TopoDS_Shape build(const SurfaceSetOf<double>& s) { return brep_of(s, 0.02 * model_.tolerance); }
  TopoDS_Shape build(const SuperellipsoidOf<double>& s) { return approximated(s); }
  TopoDS_Shape build(const SupertoroidOf<double>& s) { return approximated(s); }
  template <class S>
  TopoDS_Shape approximated(const S& s) {
    double error = 0;
    auto shape = brep_of(s, model_.tolerance / 10, error);
    error_ = std::max(error_, error);
    return shape;
  }
  TopoDS_Shape build(const UnionOf<double>& s) {
    if (s.objects.size() == 1) return built_.at(s.objects[0]);
    return unified(unwrapped(combined<BRepAlgoAPI_Fuse>(first(s.objects), rest(s.objects))));
  }
  TopoDS_Shape build(const DifferenceOf<double>& s) {
    if (s.objects.size() == 1) return built_.at(s.objects[0]);
    return unified(unwrapped(combined<BRepAlgoAPI_Cut>(first(s.objects), rest(s.objects))));
  }
  TopoDS_Shape build(const IntersectionOf<double>& s) {
    // Several tools at once would mean their union, so one after the other.
    TopoDS_Shape common = built_.at(s.objects[0]);
    for (std::size_t i = 1; i < s.objects.size() && !common.IsNull(); ++i) {
      TopTools_ListOfShape a, b;
      a.Append(common);
      b.Append(built_.at(s.objects[i]));
      common = unwrapped(combined<BRepAlgoAPI_Common>(a, b));
    }
    return common;
  }
  TopTools_ListOfShape first(const std::vector<std::string>& names) const {
    TopTools_ListOfShape list;
    list.Append(built_.at(names[0]));
    return list;
  }
  TopTools_ListOfShape rest(const std::vector<std::string>& names) const {
    TopTools_ListOfShape list;
    for (std::size_t i = 1; i < names.size(); ++i) list.Append(built_.at(names[i]));
    return list;
  }

  const Model& model_;
  Values values_;
  std::map<std::string, TopoDS_Shape> built_;
  double error_ = 0;
};

/// Signed volume of the triangles, and a point on each face inside its largest triangle.
struct Tessellation {
  double volume = 0;
  bool complete = true;
  std::vector<Vec3> inner_points;
};

Tessellation tessellated(const TopoDS_Shape& shape, const TopTools_IndexedMapOfShape& faces, double deflection) {
  Tessellation result;
  BRepMesh_IncrementalMesh(shape, deflection, false, 0.3, false);
  for (int i = 1; i <= faces.Extent(); ++i) {
    const TopoDS_Face& face = TopoDS::Face(faces(i));
    TopLoc_Location location;
    const Handle(Poly_Triangulation) mesh = BRep_Tool::Triangulation(face, location);
    result.inner_points.emplace_back(0, 0, 0);
    if (mesh.IsNull() || mesh->NbTriangles() == 0) {
      result.complete = false;
      continue;
    }
    double largest = -1;
    for (int t = 1; t <= mesh->NbTriangles(); ++t) {
      int n[3];
      mesh->Triangle(t).Get(n[0], n[1], n[2]);
      gp_XYZ p[3];
      for (int k = 0; k < 3; ++k) p[k] = mesh->Node(n[k]).Transformed(location).XYZ();
      const gp_XYZ area = (p[1] - p[0]).Crossed(p[2] - p[0]);
      const double sign = face.Orientation() == TopAbs_REVERSED ? -1 : 1;
      result.volume += sign * p[0].Dot(area) / 6;
      if (area.Modulus() > largest) {
        largest = area.Modulus();
        gp_XYZ inner = (p[0] + p[1] + p[2]) / 3;
        if (mesh->HasUVNodes()) {
          const gp_XY uv = (mesh->UVNode(n[0]).XY() + mesh->UVNode(n[1]).XY() + mesh->UVNode(n[2]).XY()) / 3;
          inner = BRep_Tool::Surface(face)->Value(uv.X(), uv.Y()).XYZ();
        }
        result.inner_points.back() = Vec3(inner.X(), inner.Y(), inner.Z());
      }
    }
  }
  BRepTools::Clean(shape);  // triangles would travel into the files
  return result;
}

/// The body and what its triangles tell.
struct TessellatedBody {
  Brep brep;
  TopTools_IndexedMapOfShape faces;
  Tessellation tessellation;
};

/// Builds and checks; exceptions are the caller's.
Result<TessellatedBody> built_and_checked(const Model& model, Context& context) {
  const Model simple = lowered(model, values_of(model));
  Builder builder(simple);
  auto part = builder.build_part(context);
  if (!part.ok()) return part.error();
  const Values values = values_of(model);
  const Object& last = model.objects.back();
  const std::string where = "object '" + last.name + "': ";

  TessellatedBody body;
  Brep& brep = body.brep;
  brep.solid = !is_sheet(last.shape);
  brep.error = builder.error();
  brep.shape =
      std::make_shared<TopoDS_Shape>(model.as_scanned ? moved(*part, evaluate(model.scan_from_part, values)) : *part);
  const TopoDS_Shape& shape = *brep.shape;

  TopExp::MapShapes(shape, TopAbs_FACE, body.faces);
  if (body.faces.Extent() == 0) return bad_input(where + "expected a body, found nothing left of it");
  if (!BRepCheck_Analyzer(shape).IsValid()) {
    return bad_input(where + "expected a valid boundary, OpenCASCADE's check refuses it");
  }
  body.tessellation = tessellated(shape, body.faces, model.tolerance);
  if (brep.solid) {
    const double volume = volume_of(shape), allowed = 1e-3 * std::abs(volume) + 2 * model.tolerance * area_of(shape);
    if (!(volume > 0) || !body.tessellation.complete || std::abs(volume - body.tessellation.volume) > allowed) {
      return bad_input(where + "expected a boundary whose volume agrees with its triangles, found " +
                       print_number(volume) + " and " + print_number(body.tessellation.volume) + " mm^3");
    }
  }
  return body;
}

void name_faces(TessellatedBody& body, const Model& model) {
  const ModelDistance distance(model);
  std::map<std::string, int> object_number;
  for (std::size_t i = 0; i < model.objects.size(); ++i) object_number[model.objects[i].name] = static_cast<int>(i);
  std::map<std::string, int> used;
  for (int i = 1; i <= body.faces.Extent(); ++i) {
    const ModelHit hit = distance(body.tessellation.inner_points[static_cast<std::size_t>(i) - 1]);
    const ModelFace& named = distance.faces()[static_cast<std::size_t>(hit.face)];
    const int count = ++used[named.name];
    WrittenFace face;
    face.face = std::make_shared<TopoDS_Shape>(body.faces(i));
    face.name = count == 1 ? named.name : named.name + " (" + std::to_string(count) + ")";
    face.color = palette[static_cast<std::size_t>(object_number.at(named.object)) % palette.size()];
    body.brep.faces.push_back(std::move(face));
  }
}

Result<Brep> built(const Model& model, bool named, Context& context) {
  try {
    auto body = built_and_checked(model, context);
    if (!body.ok()) return body.error();
    if (named && body->faces.Extent() <= most_named_faces) name_faces(*body, model);
    return std::move(body->brep);
  } catch (const Standard_Failure& failure) {
    return bad_input("object '" + model.objects.back().name +
                     "': expected a boundary that can be measured, OpenCASCADE says: " + failure.GetMessageString());
  }
}

}  // namespace

Result<Brep> build_brep(const CheckedModel& model, Context& context) { return built(*model, true, context); }

Result<Brep> build_body(const CheckedModel& model, Context& context) { return built(*model, false, context); }

Result<Brep> brep_of(const CheckedModel& model, const EmitOptions& options, Context& context) {
  if (!options.brep) return build_brep(model, context);
  auto& built = options.brep->built;
  if (!built) built = build_brep(model, context);
  return *built;
}

}  // namespace partscribe::codegen
