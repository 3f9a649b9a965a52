// Reads the faces of a STEP file by OpenCASCADE and meshes them.
#include "truth.h"

#include <BRepAdaptor_Surface.hxx>
#include <BRepBndLib.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <Eigen/Geometry>
#include <GeomAbs_SurfaceType.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_Surface.hxx>
#include <STEPControl_Reader.hxx>
#include <ShapeCustom_Surface.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <algorithm>
#include <cmath>
#include <map>

#include "verify/exchange/mesh_shape.h"

namespace bench {
namespace {

constexpr double same_surface = 1e-3;  // mm, between a spline and the surface that it is

Vec3 vec(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }
Vec3 vec(const gp_Dir& d) { return {d.X(), d.Y(), d.Z()}; }

/// False: none of the kinds with a closed form.
bool take_surface(const Adaptor3d_Surface& surface, TrueFace& face) {
  Primitive& p = face.surface;
  const auto round = [&](FaceKind kind, PrimitiveKind primitive, const gp_Ax3& frame) {
    face.kind = kind;
    p.kind = primitive;
    p.point = vec(frame.Location());
    p.axis = vec(frame.Direction());
  };
  switch (surface.GetType()) {
    case GeomAbs_Plane:
      round(FaceKind::plane, PrimitiveKind::plane, surface.Plane().Position());
      return true;
    case GeomAbs_Cylinder:
      round(FaceKind::cylinder, PrimitiveKind::cylinder, surface.Cylinder().Position());
      p.radius = surface.Cylinder().Radius();
      return true;
    case GeomAbs_Cone: {
      const gp_Cone cone = surface.Cone();
      round(FaceKind::cone, PrimitiveKind::cone, cone.Position());
      p.radius = cone.RefRadius();
      p.half_angle = std::abs(cone.SemiAngle());
      if (cone.SemiAngle() < 0) p.axis = -p.axis;
      return true;
    }
    case GeomAbs_Sphere:
      round(FaceKind::sphere, PrimitiveKind::sphere, surface.Sphere().Position());
      p.radius = surface.Sphere().Radius();
      return true;
    case GeomAbs_Torus:
      round(FaceKind::torus, PrimitiveKind::torus, surface.Torus().Position());
      p.radius = surface.Torus().MajorRadius();
      p.tube = surface.Torus().MinorRadius();
      return true;
    default:
      return false;
  }
}

TrueFace face_of_shape(const TopoDS_Face& shape) {
  TrueFace face;
  const BRepAdaptor_Surface trimmed(shape);
  if (take_surface(trimmed, face)) return face;
  // Extrusions of circles, splines through cylinders and the like.
  const Handle(Geom_Surface) bounded =
      new Geom_RectangularTrimmedSurface(BRep_Tool::Surface(shape), trimmed.FirstUParameter(), trimmed.LastUParameter(),
                                         trimmed.FirstVParameter(), trimmed.LastVParameter());
  try {
    ShapeCustom_Surface converter(bounded);
    const Handle(Geom_Surface) analytic = converter.ConvertToAnalytical(same_surface, Standard_False);
    if (!analytic.IsNull()) take_surface(GeomAdaptor_Surface(analytic), face);
  } catch (const Standard_Failure&) {
    face.kind = FaceKind::free_form;
  }
  return face;
}

/// Corners as floats, equal ones united, triangles that collapse left out.
void round_corners(Truth& truth) {
  TriangleMesh rounded;
  std::map<std::array<double, 3>, std::uint32_t> known;
  std::vector<std::uint32_t> index;
  for (const Vec3& v : truth.mesh.vertices) {
    const Vec3 w = v.cast<float>().cast<double>();
    const auto [at, fresh] =
        known.try_emplace({w.x(), w.y(), w.z()}, static_cast<std::uint32_t>(rounded.vertices.size()));
    if (fresh) rounded.vertices.push_back(w);
    index.push_back(at->second);
  }
  std::vector<std::uint32_t> face_of;
  for (std::size_t i = 0; i < truth.mesh.triangles.size(); ++i) {
    const auto& t = truth.mesh.triangles[i];
    const std::array<std::uint32_t, 3> corners{index[t[0]], index[t[1]], index[t[2]]};
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    rounded.triangles.push_back(corners);
    face_of.push_back(truth.face_of[i]);
  }
  truth.mesh = std::move(rounded);
  truth.face_of = std::move(face_of);
}

}  // namespace

Result<Truth> read_truth(const Path& step, double deflection) {
  STEPControl_Reader reader;
  if (reader.ReadFile(step.string().c_str()) != IFSelect_RetDone)
    return bad_input(step.string() + ": no STEP file that can be read");
  reader.TransferRoots();
  const TopoDS_Shape shape = reader.OneShape();
  if (shape.IsNull()) return bad_input(step.string() + ": holds no shape");
  return truth_of(shape, deflection);
}

Truth truth_of(const TopoDS_Shape& shape, double deflection) {
  if (!(deflection > 0)) {
    Bnd_Box box;
    BRepBndLib::AddOptimal(shape, box, Standard_False, Standard_False);
    deflection = std::sqrt(box.SquareExtent()) / 2000;
  }
  Truth truth;
  for (TopExp_Explorer faces(shape, TopAbs_FACE); faces.More(); faces.Next())
    truth.faces.push_back(face_of_shape(TopoDS::Face(faces.Current())));
  auto meshed = partscribe::verify::mesh_shape(shape, 10 * deflection);
  truth.error = meshed.error;
  truth.mesh = std::move(meshed.mesh);
  truth.face_of = std::move(meshed.face_of);
  round_corners(truth);

  for (std::uint32_t i = 0; i < truth.mesh.triangles.size(); ++i) {
    TrueFace& face = truth.faces[truth.face_of[i]];
    const Vec3 a = truth.mesh.corner(i, 0), b = truth.mesh.corner(i, 1), c = truth.mesh.corner(i, 2);
    const double area = 0.5 * (b - a).cross(c - a).norm();
    face.triangles.push_back(i);
    face.area += area;
    face.middle += area * (a + b + c) / 3;
    truth.area += area;
  }
  for (auto& face : truth.faces) {
    if (face.kind == FaceKind::free_form || !(face.area > 0)) continue;
    face.middle /= face.area;
    Primitive& p = face.surface;
    if (face.kind == FaceKind::cone) {  // the radius that counts is that of the face
      const double along = (face.middle - p.point).dot(p.axis);
      p.point += along * p.axis;
      p.radius += along * std::tan(p.half_angle);
      if (p.radius < 0) p.radius = -p.radius, p.axis = -p.axis;
    }
    // Which side is material is read off the triangles, which face outward.
    double outward = 0;
    for (const auto t : face.triangles) {
      const Vec3 a = truth.mesh.corner(t, 0), b = truth.mesh.corner(t, 1), c = truth.mesh.corner(t, 2);
      outward += (b - a).cross(c - a).dot(surface_normal(p, (a + b + c) / 3));
    }
    if (face.kind == FaceKind::plane)
      p.axis *= outward < 0 ? -1 : 1, p.point = face.middle;
    else
      face.hollow = outward < 0;
  }
  return truth;
}

}  // namespace bench
