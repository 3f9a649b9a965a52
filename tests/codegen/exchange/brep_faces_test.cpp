/// Claims about exact boundaries of triangulated bodies with faces.
#include "codegen/exchange/brep_faces.h"

#include <BRepAdaptor_Surface.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <GProp_GProps.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <algorithm>
#include <catch2/catch.hpp>
#include <map>

#include "codegen/exchange/face_borders.h"
#include "core/number.h"
#include "geometry/segment/faces.h"
#include "testing/meshes.h"

namespace partscribe::testing {
namespace {

using codegen::FacedBody;

FacedBody body_of(const TriangleMesh& mesh) {
  FaceOptions options;
  options.tolerance = 0.02;
  Context context;
  const Faces faces = faces_of_mesh(mesh, options, context);
  FacedBody body{mesh, faces.face_of, {}};
  for (const auto& face : faces.faces) {
    codegen::AnalyticFace analytic;
    if (face.kind != FaceKind::free_form) analytic.surface = face.surface();
    analytic.hollow = face.hollow;
    body.faces.push_back(analytic);
  }
  return body;
}

struct Counted {
  std::map<GeomAbs_SurfaceType, int> kinds;
  int solids = 0;
  double volume = 0;
  bool valid = false;
};

Counted counted(const TopoDS_Shape& shape) {
  Counted result;
  if (shape.IsNull()) return result;
  TopTools_IndexedMapOfShape faces;
  TopExp::MapShapes(shape, TopAbs_FACE, faces);
  for (int i = 1; i <= faces.Extent(); ++i) ++result.kinds[BRepAdaptor_Surface(TopoDS::Face(faces(i))).GetType()];
  TopTools_IndexedMapOfShape solids;
  TopExp::MapShapes(shape, TopAbs_SOLID, solids);
  result.solids = solids.Extent();
  GProp_GProps properties;
  BRepGProp::VolumeProperties(shape, properties);
  result.volume = properties.Mass();
  result.valid = BRepCheck_Analyzer(shape).IsValid();
  return result;
}

TEST_CASE("faced bodies: a hole drawn with 16 sides is a true cylinder in a body of exact volume") {
  FacedBody body = body_of(holed_plate(20, 10, 6, 0, 0, 16));
  const Counted made = counted(codegen::brep_of_faces(body, 1e-3));
  CHECK(made.valid);
  CHECK(made.solids == 1);
  CHECK(made.kinds.at(GeomAbs_Plane) == 6);
  CHECK(made.kinds.at(GeomAbs_Cylinder) == 1);
  CHECK(made.volume == Approx(40 * 40 * 10 - pi * 36 * 10).epsilon(1e-6));
}

TEST_CASE("faced bodies: a rounded edge is trimmed by its tangent lines") {
  FacedBody body = body_of(rounded_block(30, 4, 12));
  const Counted made = counted(codegen::brep_of_faces(body, 1e-3));
  CHECK(made.valid);
  CHECK(made.kinds.at(GeomAbs_Cylinder) == 1);
  CHECK(made.volume == Approx(12 * (30 * 30 - (4 - pi) * 4)).epsilon(1e-5));
}

TEST_CASE("faced bodies: cone and cylinder meet in a circle, with their own seams") {
  FacedBody body = body_of(turned({{0, 0}, {8, 0}, {8, 12}, {4, 20}, {0, 20}}, 40));
  const Counted made = counted(codegen::brep_of_faces(body, 1e-3));
  CHECK(made.valid);
  CHECK(made.kinds.at(GeomAbs_Cone) == 1);
  CHECK(made.kinds.at(GeomAbs_Cylinder) == 1);
  CHECK(made.volume == Approx(pi * 64 * 12 + pi * 8 / 3 * (64 + 32 + 16)).epsilon(1e-6));
}

TEST_CASE("faced bodies: what has no surface stays triangles, and the body closed") {
  FacedBody body = body_of(holed_plate(20, 10, 6, 0, 0, 16));
  int triangles = 0;
  for (std::size_t f = 0; f < body.faces.size(); ++f)
    if (body.faces[f].surface->kind == PrimitiveKind::cylinder) {
      body.faces[f].surface.reset();
      triangles = static_cast<int>(std::count(body.face_of.begin(), body.face_of.end(), f));
    }
  const Counted made = counted(codegen::brep_of_faces(body, 1e-3));
  CHECK(made.valid);
  CHECK(made.kinds.count(GeomAbs_Cylinder) == 0);
  CHECK(made.kinds.at(GeomAbs_Plane) == 6 + triangles);
  CHECK(made.volume == Approx(volume(body.mesh)).epsilon(1e-6));
}

TEST_CASE("faced bodies: a cavity is cut out of the body around it, and a body beside it stays one of its own") {
  TriangleMesh cavity = sphere(3, 24);
  for (auto& t : cavity.triangles) std::swap(t[1], t[2]);
  const TriangleMesh block = moved(holed_plate(20, 20, 4, 0, 0, 16), {0, 0, -10});
  const TriangleMesh beside = moved(turned({{0, 0}, {5, 0}, {5, 6}, {0, 6}}, 24), {60, 0, 0});
  FacedBody body = body_of(joined(joined(block, moved(cavity, {12, 12, 0})), beside));
  const Counted made = counted(codegen::brep_of_faces(body, 1e-3));
  CHECK(made.valid);
  CHECK(made.solids == 2);
  CHECK(made.volume == Approx(40 * 40 * 20 - pi * 16 * 20 - 4 * pi / 3 * 27 + pi * 25 * 6).epsilon(1e-3));
}

TEST_CASE("faced bodies: an open mesh has none") {
  TriangleMesh mesh = holed_plate(20, 10, 6, 0, 0, 16);
  FacedBody body = body_of(mesh);
  body.mesh.triangles.pop_back(), body.face_of.pop_back();
  CHECK(codegen::brep_of_faces(body, 1e-3).IsNull());
}

TEST_CASE("faced bodies: each border belongs to two faces, once in either direction") {
  const FacedBody body = body_of(holed_plate(20, 10, 6, 0, 0, 16));
  const auto borders = codegen::face_borders(body);
  CHECK(borders.curves.size() == 12 + 2);
  std::vector<int> forward(borders.curves.size(), 0), backward = forward;
  for (std::size_t f = 0; f < borders.loops.size(); ++f)
    for (const auto& loop : borders.loops[f])
      for (const auto& use : loop) {
        (use.forward ? forward : backward)[use.curve]++;
        CHECK((use.forward ? borders.curves[use.curve].left : borders.curves[use.curve].right) == f);
      }
  for (std::size_t c = 0; c < forward.size(); ++c) CHECK((forward[c] == 1 && backward[c] == 1));
}

}  // namespace
}  // namespace partscribe::testing
