/// Claims about running artifacts by their own programs.
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepGProp.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <GProp_GProps.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESControl_Writer.hxx>
#include <IGESData_HArray1OfIGESEntity.hxx>
#include <IGESGeom_TransformationMatrix.hxx>
#include <IGESSolid_Block.hxx>
#include <IGESSolid_BooleanTree.hxx>
#include <IGESSolid_Cylinder.hxx>
#include <IGESSolid_Sphere.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <STEPControl_Writer.hxx>
#include <TColStd_HArray1OfInteger.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS_Shape.hxx>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <gp_Trsf.hxx>

#include "core/process.h"
#include "testing/meshes.h"

using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

struct Bench {
  Bench() { Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer)); }
  TemporaryDirectory folder;
  Context context;

  Evaluation evaluate(const Path& file, double tolerance = 0.1) {
    EvaluateOptions options;
    options.tolerance = tolerance;
    auto result = evaluate_artifact(file, options, context);
    INFO((result.ok() ? "" : result.error().message));
    REQUIRE(result.ok());
    return *result;
  }
  Path write(const std::string& name, const std::string& text) {
    REQUIRE(write_file(folder.path() / name, text).ok());
    return folder.path() / name;
  }
  Evaluation scad(const std::string& text) { return evaluate(write("part.scad", text)); }
};

std::string complaints(const Evaluation& e) {
  std::string text;
  for (const auto& c : e.complaints) text += c + "\n";
  return text;
}

bool have_openscad() {
  if (!find_program("openscad").empty()) return true;
  WARN("openscad is not installed: not run");
  return false;
}

TopoDS_Shape drilled_block() {
  return BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(40.0, 30.0, 20.0).Shape(),
                         BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(20, 15, -5), gp_Dir(0, 0, 1)), 6, 30).Shape())
      .Shape();
}

const double drilled_volume = 40 * 30 * 20 - pi * 36 * 20;

void write_step(const TopoDS_Shape& shape, const Path& file) {
  STEPControl_Writer writer;
  REQUIRE(writer.Transfer(shape, STEPControl_AsIs) == IFSelect_RetDone);
  REQUIRE(writer.Write(file.c_str()) == IFSelect_RetDone);
}

/// block - cylinder as entities 150, 154 and 180; the body beside it if `with_body`.
void write_tree(const Path& file, double tree_radius, bool with_body) {
  IGESControl_Controller::Init();
  IGESControl_Writer writer("MM", 1);
  if (with_body) writer.AddShape(drilled_block());
  Handle(IGESSolid_Block) block = new IGESSolid_Block;
  block->Init(gp_XYZ(40, 30, 20), gp_XYZ(0, 0, 0), gp_XYZ(1, 0, 0), gp_XYZ(0, 0, 1));
  Handle(IGESSolid_Cylinder) hole = new IGESSolid_Cylinder;
  hole->Init(30, tree_radius, gp_XYZ(20, 15, -5), gp_XYZ(0, 0, 1));
  Handle(IGESData_HArray1OfIGESEntity) operands = new IGESData_HArray1OfIGESEntity(1, 3);
  Handle(TColStd_HArray1OfInteger) operations = new TColStd_HArray1OfInteger(1, 3);
  operations->Init(0);
  operands->SetValue(1, block), operands->SetValue(2, hole), operations->SetValue(3, 3);
  Handle(IGESSolid_BooleanTree) tree = new IGESSolid_BooleanTree;
  tree->Init(operands, operations);
  for (const Handle(IGESData_IGESEntity) & e :
       {Handle(IGESData_IGESEntity)(block), Handle(IGESData_IGESEntity)(hole), Handle(IGESData_IGESEntity)(tree)})
    REQUIRE(writer.AddEntity(e));
  writer.ComputeModel();
  REQUIRE(writer.Write(file.c_str()));
}

}  // namespace

TEST_CASE("evaluate: how to draw finer circles depends on the kind of file") {
  CHECK(how_to_draw_finer("plate.scad", 24) == "raise $fn to 24");
  CHECK(how_to_draw_finer("plate.STL", 24) == "export it with finer facets");
  CHECK(how_to_draw_finer("plate.step", 24).empty());
}

TEST_CASE("run openscad: a sound script gives its solid") {
  if (!have_openscad()) return;
  Bench bench;
  const auto e =
      bench.scad("size = 10; difference() { cube(size); translate([5, 5, -1]) cylinder(r = 2, h = 12, $fn = 64); }");
  INFO(complaints(e));
  CHECK_FALSE(e.failed);
  CHECK(e.solid);
  CHECK(e.backend == "openscad");
  CHECK(e.program == "openscad");
  CHECK_FALSE(e.version.empty());
  CHECK(volume(e.mesh) == Approx(1000 - 10 * 32 * 4 * std::sin(2 * pi / 64)).epsilon(1e-6));
  const auto again =
      bench.scad("size = 10; difference() { cube(size); translate([5, 5, -1]) cylinder(r = 2, h = 12, $fn = 64); }");
  CHECK(again.mesh.vertices == e.mesh.vertices);
  CHECK(again.mesh.triangles == e.mesh.triangles);
}

TEST_CASE("run openscad: an include beside the script is found") {
  if (!have_openscad()) return;
  Bench bench;
  bench.write("library.scad", "module lump() { cube(3); }");
  const auto e = bench.scad("include <library.scad>\nlump();");
  INFO(complaints(e));
  CHECK_FALSE(e.failed);
  CHECK(volume(e.mesh) == Approx(27));
}

TEST_CASE("run openscad: far from the origin a script is as exact as near it, whoever wrote it") {
  if (!have_openscad()) return;
  Bench bench;
  bench.write("library.scad", "module lump() { cube(3); }");
  bench.write("sizes.scad", "size = 10; function half(x) = x / 2;");
  const std::string script =
      "/* [Sizes] */\nuse <library.scad>\n  include <sizes.scad>\nassert(size > 0);\nmodule part() difference() { "
      "cube(size); translate([half(size), half(size), "
      "-1]) cylinder(r = 2.3, h = 12, $fn = 64); }\nmodule placed() translate(far) rotate([10, 20, 30]) children();\n"
      "placed() part();\nplaced() translate([20, 0, 0]) lump(); // the end";
  const auto near = bench.scad("far = [0, 0, 0];\n" + script),
             far = bench.scad("far = [694370.12345, -5155489.678, 381.5];\n" + script);
  INFO(complaints(far));
  CHECK_FALSE(far.failed);
  CHECK(far.solid);
  CHECK(near.error < 1e-5);
  CHECK(far.error < 1e-5);
  CHECK(volume(far.mesh) == Approx(volume(near.mesh)).epsilon(1e-5));
  const MeshDistance moved(partscribe::testing::moved(near.mesh, Vec3(694370.12345, -5155489.678, 381.5)));
  for (const auto& v : far.mesh.vertices) REQUIRE(moved.closest(v).distance < 1e-5);
  // What cannot be moved is evaluated as it is, and its error is said.
  bench.write("lump.stl", write_stl(box({0, 0, 0}, {20, 20, 20})));
  const auto foreign = bench.scad("translate([5e6, 0, 0]) import(\"lump.stl\");");
  INFO(complaints(foreign));
  CHECK_FALSE(foreign.failed);
  CHECK(foreign.error > 0.1);
}

TEST_CASE("run openscad: whatever it complains about is refused") {
  if (!have_openscad()) return;
  Bench bench;
  const std::string open_tetrahedron = "polyhedron([[0,0,0],[10,0,0],[0,10,0],[0,0,10]], [[0,1,2],[0,3,1],[0,2,3]]);";
  const auto syntax = bench.scad("cube(10");
  CHECK(syntax.failed);
  CHECK(complaints(syntax).find("ERROR") != std::string::npos);
  const auto unknown = bench.scad("cube(10); bogus();");
  CHECK(unknown.failed);
  CHECK(complaints(unknown).find("bogus") != std::string::npos);
  const auto asserted = bench.scad("assert(1 > 2); cube(10);");
  CHECK(asserted.failed);
  // 2021.01 ends with 0 here and drops the open part.
  const auto dropped = bench.scad("difference() { cube(10); " + open_tetrahedron + " }");
  CHECK(dropped.failed);
  const auto open = bench.scad(open_tetrahedron);
  CHECK_FALSE(open.solid);
  CHECK(complaints(open).find("open") != std::string::npos);
  const auto nothing = bench.scad("x = 1;");
  CHECK(nothing.failed);
  const auto slow =
      evaluate_artifact(bench.write("slow.scad",
                                    "for (i = [0:100]) translate([i * 3, i % 7, 0]) difference() "
                                    "{ sphere(10, $fn = 100); translate([5, 0, 0]) sphere(9, $fn = 90); }"),
                        {0.1, 0.3, 4096}, bench.context);
  REQUIRE_FALSE(slow.ok());
  CHECK(slow.error().kind == ErrorKind::stopped);
}

TEST_CASE("run openscad: without the program the verdict is not run") {
  Bench bench;
  const auto file = bench.write("part.scad", "cube(10);");
  const std::string path = std::getenv("PATH") ? std::getenv("PATH") : "";
  ::setenv("PATH", bench.folder.path().c_str(), 1);
  const auto scan = scanned(box({0, 0, 0}, {10, 10, 10}), 2000, 0);
  const auto verdict = verify_artifacts({file}, scan, {}, {}, bench.context);
  ::setenv("PATH", path.c_str(), 1);
  REQUIRE(verdict.ok());
  CHECK(verdict->verdict == Outcome::not_run);
  CHECK(exit_code_of(verdict->verdict) == 4);
  CHECK(all_reasons(*verdict).find("openscad") != std::string::npos);
}

TEST_CASE("run openscad: script and scan meet in one verdict") {
  if (!have_openscad()) return;
  Bench bench;
  const auto scan = scanned(box({0, 0, 0}, {20, 15, 10}), 20000, 0.02);
  VerifyOptions options;
  const auto good =
      verify_artifacts({bench.write("part.scad", "cube([20, 15, 10]);")}, scan, {}, options, bench.context);
  REQUIRE(good.ok());
  INFO(all_reasons(*good));
  CHECK(good->verdict == Outcome::verified);
  const auto bad =
      verify_artifacts({bench.write("part.scad", "cube([20, 15, 10.2]);")}, scan, {}, options, bench.context);
  REQUIRE(bad.ok());
  CHECK(bad->verdict == Outcome::out_of_tolerance);
  const auto warned =
      verify_artifacts({bench.write("part.scad", "cube([20, 15, 10]); bogus();")}, scan, {}, options, bench.context);
  REQUIRE(warned.ok());
  CHECK(warned->verdict == Outcome::out_of_tolerance);
}

TEST_CASE("run occt: a STEP solid comes back closed and within its measured error") {
  Bench bench;
  const Path file = bench.folder.path() / "part.step";
  write_step(drilled_block(), file);
  const auto e = bench.evaluate(file);
  INFO(complaints(e));
  CHECK_FALSE(e.failed);
  CHECK(e.solid);
  CHECK(e.backend == "step");
  CHECK(e.error > 0);
  CHECK(e.error <= 0.02);
  CHECK(volume(e.mesh) == Approx(drilled_volume).epsilon(1e-3));
  double worst = 0;  // the hole's facets really are that close to the cylinder
  for (std::size_t t = 0; t < e.mesh.triangles.size(); ++t) {
    const Vec3 c = (e.mesh.corner(t, 0) + e.mesh.corner(t, 1) + e.mesh.corner(t, 2)) / 3;
    const Vec3 n = triangle_normal(e.mesh, t);
    const double r = std::hypot(c.x() - 20, c.y() - 15);
    if (std::abs(n.z()) < 0.1 && r < 7) worst = std::max(worst, std::abs(r - 6));
  }
  CHECK(worst <= e.error * 1.001 + 1e-9);
}

TEST_CASE("run occt: IGES in both modes gives the same solid") {
  Bench bench;
  IGESControl_Controller::Init();
  for (const int mode : {0, 1}) {
    const Path file = bench.folder.path() / ("part" + std::to_string(mode) + ".igs");
    IGESControl_Writer writer("MM", mode);
    REQUIRE(writer.AddShape(drilled_block()));
    writer.ComputeModel();
    REQUIRE(writer.Write(file.c_str()));
    const auto e = bench.evaluate(file);
    INFO("mode " << mode << ": " << complaints(e));
    CHECK_FALSE(e.failed);
    CHECK(e.solid);
    CHECK(volume(e.mesh) == Approx(drilled_volume).epsilon(1e-3));
  }
}

TEST_CASE("run occt: inches become millimetres") {
  Bench bench;
  IGESControl_Controller::Init();
  const Path file = bench.folder.path() / "part.igs";
  IGESControl_Writer writer("INCH", 1);
  REQUIRE(writer.AddShape(drilled_block()));
  writer.ComputeModel();
  REQUIRE(writer.Write(file.c_str()));
  CHECK(volume(bench.evaluate(file).mesh) == Approx(drilled_volume).epsilon(1e-3));
}

TEST_CASE("run occt: a sphere is refined until its error is small") {
  Bench bench;
  const Path file = bench.folder.path() / "ball.step";
  write_step(BRepPrimAPI_MakeSphere(10.0).Shape(), file);
  for (const double tolerance : {1.0, 0.1}) {
    const auto e = bench.evaluate(file, tolerance);
    INFO(complaints(e));
    CHECK(e.solid);
    CHECK(e.error <= tolerance / 4);
    CHECK(volume(e.mesh) == Approx(4000 * pi / 3).epsilon(0.02));
  }
}

TEST_CASE("run occt: a ball a thousand times as large as what was scanned is meshed coarsely") {
  Bench bench;
  const Path file = bench.folder.path() / "ball.step";
  write_step(BRepPrimAPI_MakeSphere(1000.0).Shape(), file);
  Context context;
  const auto as_scanned = evaluate_artifact(file, {1.0, 600, 8192, 2000.0}, context);
  const auto far_too_large = evaluate_artifact(file, {1.0, 600, 8192, 2.0}, context);
  REQUIRE(as_scanned.ok());
  REQUIRE(far_too_large.ok());
  CHECK(as_scanned->error <= 0.25);
  CHECK(10 * far_too_large->mesh.triangles.size() < as_scanned->mesh.triangles.size());
  CHECK(volume(far_too_large->mesh) == Approx(4e9 * pi / 3).epsilon(0.02));
}

TEST_CASE("run occt: an open set of faces is no solid") {
  Bench bench;
  IGESControl_Controller::Init();
  const Path file = bench.folder.path() / "sheet.igs";
  IGESControl_Writer writer("MM", 0);
  int kept = 0;
  const TopoDS_Shape block = BRepPrimAPI_MakeBox(10.0, 10.0, 10.0).Shape();
  for (TopExp_Explorer faces(block, TopAbs_FACE); faces.More(); faces.Next())
    if (++kept <= 5) REQUIRE(writer.AddShape(faces.Current()));
  writer.ComputeModel();
  REQUIRE(writer.Write(file.c_str()));
  const auto e = bench.evaluate(file);
  CHECK_FALSE(e.solid);
  CHECK(complaints(e).find("4 boundary edges") != std::string::npos);
  CHECK(area(e.mesh) == Approx(500));
}

TEST_CASE(
    "run occt: faces that miss one another are sewn up to a share of the tolerance, beyond it width and place are "
    "named") {
  Bench bench;
  IGESControl_Controller::Init();
  const Path file = bench.folder.path() / "part.igs";
  // Six loose faces; the one at x = 10 stands off.
  const auto write_with_gap = [&](double gap) {
    IGESControl_Writer writer("MM", 0);
    const TopoDS_Shape block = BRepPrimAPI_MakeBox(10.0, 10.0, 10.0).Shape();
    for (TopExp_Explorer faces(block, TopAbs_FACE); faces.More(); faces.Next()) {
      GProp_GProps properties;
      BRepGProp::SurfaceProperties(faces.Current(), properties);
      gp_Trsf aside;
      if (properties.CentreOfMass().X() > 9) aside.SetTranslation(gp_Vec(gap, 0, 0));
      REQUIRE(writer.AddShape(BRepBuilderAPI_Transform(faces.Current(), aside, true).Shape()));
    }
    writer.ComputeModel();
    REQUIRE(writer.Write(file.c_str()));
  };
  write_with_gap(0.01);
  const auto sewn = bench.evaluate(file, 0.1);
  INFO(complaints(sewn));
  CHECK(sewn.solid);
  CHECK(sewn.gap.width <= 0.02);
  CHECK(volume(sewn.mesh) == Approx(1000).epsilon(0.002));
  CHECK_FALSE(bench.evaluate(file, 0.01).solid);
  write_with_gap(0.3);
  const auto open = bench.evaluate(file, 0.1);
  CHECK_FALSE(open.solid);
  INFO(complaints(open));
  CHECK(complaints(open).find("its faces do not meet: they are up to 0.3 mm apart, near (10") != std::string::npos);
}

TEST_CASE("run occt: a boolean tree beside the body must describe the same body") {
  Bench bench;
  const Path file = bench.folder.path() / "part.igs";
  write_tree(file, 6, true);
  const auto same = bench.evaluate(file);
  INFO(complaints(same));
  CHECK_FALSE(same.failed);
  CHECK(same.solid);
  write_tree(file, 6.2, true);
  const auto different = bench.evaluate(file);
  CHECK(different.failed);
  CHECK(complaints(different).find("boolean tree and its body differ") != std::string::npos);
  write_tree(file, 6, false);
  const auto alone = bench.evaluate(file);
  INFO(complaints(alone));
  CHECK_FALSE(alone.failed);
  CHECK(alone.solid);
  CHECK(volume(alone.mesh) == Approx(drilled_volume).epsilon(1e-3));
}

TEST_CASE("run occt: bad_file is refused with a complaint") {
  Bench bench;
  for (const char* name : {"bad_part.igs", "bad_part.step"}) {
    const auto e = bench.evaluate(bench.write(name, "this is no CAD file\n"));
    CHECK(e.failed);
    CHECK_FALSE(complaints(e).empty());
    CHECK(e.mesh.empty());
  }
}

TEST_CASE("run mesh files: points without triangles are no artifact") {
  Bench bench;
  PointCloud cloud;
  cloud.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const auto file = bench.write("cloud.ply", write_cloud_ply(cloud));
  const auto result = evaluate_artifact(file, {}, bench.context);
  REQUIRE_FALSE(result.ok());
  CHECK(result.error().message.find("no triangles") != std::string::npos);
  const auto mesh_file = bench.write("box.ply", write_mesh_ply(box({0, 0, 0}, {1, 2, 3})));
  CHECK(bench.evaluate(mesh_file).solid);
}
