/// Backends: what is written is what was committed, is the same every time, and really describes the model.
///
/// PARTSCRIBE_WRITE_GOLDENS=1 rewrites tests/golden and ends red: regenerating is not verifying.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <sstream>

#include "codegen/describe.h"
#include "codegen/emit.h"
#include "codegen/exchange/brep.h"
#include "core/number.h"
#include "geometry/mesh/mesh_distance.h"
#include "model/distance/distance.h"
#include "model/json.h"
#include "model/surface_patches.h"
#include "testing/checked_model.h"
#include "testing/golden_models.h"
#include "testing/program.h"
#include "testing/surface_sets.h"
#include "verify/evaluate/evaluate.h"

using namespace partscribe::codegen;
using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

const std::vector<std::string> own_backends = {"openscad", "iges", "step"};

Path golden_folder(const std::string& part) { return source_file("tests/golden/" + part); }

Artifact emitted(const Model& model, const std::string& backend) {
  Context context;
  auto artifact = emit(checked_model(model), backend, {}, context);
  INFO(model.name << " " << backend << ": " << (artifact.ok() ? "" : artifact.error().message));
  REQUIRE(artifact.ok());
  return std::move(artifact).value();
}

/// What the real program makes of the artifact.
Evaluation evaluated(const Artifact& artifact, double tolerance) {
  TemporaryDirectory folder;
  for (const auto& file : artifact.files) REQUIRE(write_file(folder.path() / file.name, file.bytes).ok());
  Context context;
  auto evaluation = evaluate_artifact(folder.path() / artifact.files[0].name, {tolerance}, context);
  INFO((evaluation.ok() ? "" : evaluation.error().message));
  REQUIRE(evaluation.ok());
  return std::move(evaluation).value();
}

const Model& golden(const std::string& name) {
  static const std::vector<Model> all = golden_models();
  return *std::find_if(all.begin(), all.end(), [&](const Model& m) { return m.name == name; });
}

std::string script_of(const Model& model) { return emitted(model, "openscad").files[0].bytes; }

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

Model block_with(const Expr& size, const std::vector<Parameter>& parameters) {
  Model m;
  m.name = "block";
  m.parameters = parameters;
  m.objects = {{"block", Box{size, 10, 10}, {}, {}, ""}};
  return m;
}

Parameter parameter(const std::string& name, double value, Quantity quantity = Quantity::length) {
  Parameter p;
  p.name = name;
  p.value = p.fitted = value;
  p.quantity = quantity;
  return p;
}

Model single(const std::string& name, Shape shape, double tolerance = 0.1) {
  Model m;
  m.name = name;
  m.tolerance = tolerance;
  m.objects = {{name, std::move(shape), {}, {}, ""}};
  return m;
}

bool round_all_over(const Model& model) {
  const std::set<std::string> names = {"sphere",      "torus",      "ellipsoid", "superellipsoid",
                                       "supertoroid", "nurbs_vase", "handle"};
  return names.count(model.name) > 0;
}

/// Every backend's file, run by its own program, lies on the model and encloses the same volume.
void conforms(const Model& model) {
  const ModelDistance distance(model);
  double first_volume = 0;
  for (const auto& backend : own_backends) {
    const Evaluation evaluation = evaluated(emitted(model, backend), model.tolerance);
    INFO(model.name << " " << backend << " " << (evaluation.complaints.empty() ? "" : evaluation.complaints[0]));
    CHECK_FALSE(evaluation.failed);
    CHECK(evaluation.solid);
    double worst = 0;
    const std::size_t step = std::max<std::size_t>(1, evaluation.mesh.triangles.size() / 5000);
    for (std::size_t t = 0; t < evaluation.mesh.triangles.size(); t += step) {
      const Vec3 a = evaluation.mesh.corner(t, 0), b = evaluation.mesh.corner(t, 1), c = evaluation.mesh.corner(t, 2);
      for (const Vec3& p : {a, Vec3((a + b + c) / 3), Vec3((a + b) / 2), Vec3((b + c) / 2), Vec3((c + a) / 2)}) {
        worst = std::max(worst, std::abs(distance(p).distance));
      }
    }
    CHECK(worst < model.tolerance / 5);
    // A missing face or body shows in the volume, though every sampled point is right.
    const double enclosed = volume(evaluation.mesh);
    CHECK(enclosed > 0);
    if (first_volume == 0) first_volume = enclosed;
    CHECK(std::abs(enclosed - first_volume) < area(evaluation.mesh) * model.tolerance / 5);
  }
}

void conforms_soap(double e1, double e2, double taper) {
  conforms(single("soap", Superellipsoid{20, 12, 8, e1, e2, taper, taper / 2}, 0.8));
}

}  // namespace

TEST_CASE("goldens: every backend writes exactly the committed bytes from the committed model") {
  const bool rewrite = std::getenv("PARTSCRIBE_WRITE_GOLDENS") != nullptr;
  for (const Model& made : golden_models()) {
    const Path folder = golden_folder(made.name);
    if (rewrite) {
      std::filesystem::create_directories(folder);
      REQUIRE(write_file(folder / "model.json", write_model_json(made)).ok());
    }
    auto text = read_file(folder / "model.json");
    INFO(made.name);
    REQUIRE(text.ok());
    auto model = read_model_json(*text, made.name);
    REQUIRE(model.ok());
    for (const auto& backend : own_backends) {
      const Artifact artifact = emitted(*model, backend);
      const ArtifactFile& file = artifact.files[0];
      if (rewrite) REQUIRE(write_file(folder / file.name, file.bytes).ok());
      auto committed = read_file(folder / file.name);
      REQUIRE(committed.ok());
      CHECK(*committed == file.bytes);
    }
  }
  if (rewrite) FAIL("the goldens were rewritten; run again without PARTSCRIBE_WRITE_GOLDENS to verify them");
}

TEST_CASE("backends: the same model gives the same bytes twice in one process") {
  for (const auto& name : {"box", "pin", "bracket", "superellipsoid"}) {
    for (const auto& backend : own_backends) {
      const Artifact first = emitted(golden(name), backend), second = emitted(golden(name), backend);
      INFO(name << " " << backend);
      REQUIRE(first.files.size() == second.files.size());
      for (std::size_t i = 0; i < first.files.size(); ++i) CHECK(first.files[i].bytes == second.files[i].bytes);
    }
  }
}

TEST_CASE("backends: every shape, run by the real program, lies on the model within a fifth of the tolerance") {
  for (Model model : golden_models()) {
    if (is_sheet(model.objects.back().shape)) continue;  // they have tests of their own
    // Meshing what is round all over to a hundredth of a millimetre takes most of a minute.
    if (round_all_over(model)) model.tolerance = 0.5;
    conforms(model);
  }
}

TEST_CASE("backends: round bodies lie on the model as closely as they are committed", "[.statistics]") {
  for (const Model& model : golden_models())
    if (round_all_over(model)) conforms(model);
}

TEST_CASE("backends: superellipsoids at the edges of their domain") {
  conforms_soap(0.1, 0.1, 0);
  conforms_soap(2, 2, 0);
  conforms_soap(1, 2, 0.9);
}

TEST_CASE("backends: superellipsoids at other edges and in the middle of their domain", "[.statistics]") {
  conforms_soap(0.1, 1, 0.5);
  conforms_soap(1, 1, 0);
  conforms_soap(1.6, 0.3, -0.4);
}

TEST_CASE("backends: superellipsoids are bent a little and nearly into a ring, to either side") {
  conforms(single("bean", Superellipsoid{12, 10, 20, 0.4, 0.7, -0.3, 0.2, -0.7}, 0.8));
  conforms(single("hook", Superellipsoid{7, 10, 40, 0.2, 0.3, 0, 0.3, 2.8}, 0.8));
  conforms(single("tusk", Superellipsoid{7, 6, 40, 1.5, 1.2, 0.6, 0.6, 1.5}, 0.8));
}

TEST_CASE("backends: wedges and cones that end in an edge or a tip, or grow upwards") {
  conforms(single("prism", Wedge{30, 20, 10, 0}));
  conforms(single("overhang", Wedge{20, 20, 10, 35}));
  conforms(single("tip", Cone{12, 0, 20}, 0.5));
  conforms(single("funnel", Cone{0, 12, 20}, 0.5));
  conforms(single("almost_cylinder", Cone{12, 12, 20}));
}

TEST_CASE("backends: profiles with holes, touching the axis, and hollow fillets") {
  const Loop circle{"tube", {SketchArc{20, 5, 6, 0, radians(360), "tube", ""}}};
  const Loop core{"core", {SketchArc{20, 5, 4, radians(360), 0, "core", ""}}};
  conforms(single("pipe_ring", Revolve{Sketch{{circle, core}}}));
  const Loop half{"half", {SketchArc{0, 0, 15, radians(-90), radians(90), "ball", "axis"}}};
  conforms(single("turned_ball", Revolve{Sketch{{half}}}, 0.5));
  const Loop spool{"spool",
                   {SketchPoint{0, 0, "foot"}, SketchPoint{20, 0, "rim"}, SketchPoint{20, 5, "seat"},
                    SketchArc{20, 15, 10, radians(270), radians(90), "throat", "seat"}, SketchPoint{20, 30, "head"},
                    SketchPoint{0, 30, "axis"}}};
  conforms(single("spool", Revolve{Sketch{{spool}}}));
  const Loop square{"square",
                    {SketchPoint{0, 0, ""}, SketchPoint{30, 0, ""}, SketchPoint{30, 30, ""}, SketchPoint{0, 30, ""}}};
  const Loop window{
      "window", {SketchPoint{10, 10, ""}, SketchPoint{10, 20, ""}, SketchPoint{20, 20, ""}, SketchPoint{20, 10, ""}}};
  conforms(single("frame", Extrude{Sketch{{square, window}}, 4}));
  SketchNurbs arch{2, {0, 0, 0, 1, 1, 1}, {}, {{30, 0}, {15, 30}, {0, 0}}, "arch", "base"};
  conforms(single("vault", Extrude{Sketch{{Loop{"outline", {arch}}}}, 12}));
}

TEST_CASE("backends: walls lean in and out, at corners of every kind, and around holes") {
  const Loop outline{"outline",
                     {SketchPoint{0, 0, "front"}, SketchArc{26, 4, 4, radians(-90), 0, "round", "right"},
                      SketchPoint{30, 18, "back"}, SketchPoint{18, 18, "cheek"}, SketchPoint{15, 12, "cheek 2"},
                      SketchPoint{12, 18, "back 2"}, SketchPoint{0, 18, "left"}}};
  const Loop bore{"bore", {SketchArc{9, 7, 3, radians(360), 0, "bore", ""}}};
  const Loop slit{"slit",
                  {SketchArc{22, 9, 2, radians(90), radians(-90), "end", "side"},
                   SketchArc{18, 9, 2, radians(-90), radians(-270), "end 2", "side 2"}}};
  conforms(single("leaning_in", Extrude{Sketch{{outline, bore, slit}}, 9, 3, 0.1}));
  conforms(single("leaning_out", Extrude{Sketch{{outline, bore, slit}}, 6, 3, -0.2}));
  const Loop disc{"disc", {SketchArc{5, 2, 12, 0, radians(360), "side", ""}}};
  conforms(single("stopper", Extrude{Sketch{{disc}}, 9, 3, 0.3}));
  conforms(single("cup", Extrude{Sketch{{disc}}, 9, 0, -0.3}));
  const Loop square{"square",
                    {SketchPoint{0, 0, ""}, SketchPoint{30, 0, ""}, SketchPoint{30, 30, ""}, SketchPoint{0, 30, ""}}};
  const Loop window{
      "window", {SketchPoint{10, 10, ""}, SketchPoint{10, 20, ""}, SketchPoint{20, 20, ""}, SketchPoint{20, 10, ""}}};
  // Points where an arc ends are corners that add nothing.
  const Loop eye{"eye",
                 {SketchPoint{15, 13, "seam"}, SketchArc{15, 15, 2, radians(-90), radians(90), "half", ""},
                  SketchPoint{15, 17, "seam 2"}, SketchArc{15, 15, 2, radians(90), radians(270), "half 2", ""}}};
  conforms(single("funnels", Extrude{Sketch{{square, window, eye}}, 4, 0, 0.3}));
}

TEST_CASE("openscad: the draft stays a size of the script, and may be edited") {
  Model m;
  m.name = "key";
  m.parameters = {parameter("draft", radians(5), Quantity::angle), parameter("key_r", 3)};
  const Expr r = Expr::of("key_r");
  const Loop key{"key",
                 {SketchPoint{0, 0, "foot"}, SketchArc{Expr(20) - r, r, r, radians(-90), 0, "round", "end"},
                  SketchPoint{20, 10, "top"}, SketchPoint{0, 10, "left"}}};
  m.objects = {{"key", Extrude{Sketch{{key}}, 8, 2, Expr::of("draft")}, {}, {}, ""}};
  Artifact artifact = emitted(m, "openscad");
  std::string& script = artifact.files[0].bytes;
  CHECK(contains(script, "[[20 - key_r, key_r], key_r, -90, 0],"));
  CHECK(contains(script, "height = 8, below = 2, draft = draft, chord_error = chord_error);"));
  REQUIRE(contains(script, "draft = 5;"));
  script.replace(script.find("draft = 5;"), 10, "draft = 9;");
  m.parameters[0].value = m.parameters[0].fitted = radians(9);
  const ModelDistance steeper(m);
  const Evaluation evaluation = evaluated(artifact, m.tolerance);
  CHECK_FALSE(evaluation.failed);
  double worst = 0;
  for (const Vec3& v : evaluation.mesh.vertices) worst = std::max(worst, std::abs(steeper(v).distance));
  CHECK(worst < 1e-4);
  // Where the round would turn inside out the script says so.
  script.replace(script.find("draft = 9;"), 10, "draft = 30;");
  CHECK(evaluated(artifact, m.tolerance).failed);
  CHECK_FALSE(contains(emitted(m, "iges").files[0].bytes, "     180 "));
}

TEST_CASE("backends: an object may be used by several others, and by both sides of a cut") {
  Model m;
  m.name = "comb";
  m.objects = {{"bar", Box{40, 6, 6}, {}, {}, ""},
               {"post", Cylinder{4, 20}, {8, 3, -5, 0, 0, 0}, {}, ""},
               {"disc_1", Cylinder{12, 3}, {30, 3, 1, 0, 0, 0}, {}, ""},
               {"together", Union{{"bar", "post", "disc_1"}}, {}, {}, ""},
               {"tip", Box{60, 30, 30}, {-10, -12, -9, 0, 0, radians(3)}, {}, ""},
               {"round", Cylinder{25, 60}, {20, 3, -30, 0, 0, 0}, {}, ""},
               {"kept", Intersection{{"together", "tip", "round"}}, {}, {}, ""},
               {"bore", Cylinder{2, 40}, {8, 3, -10, 0, 0, 0}, {}, ""},
               {"comb", Difference{{"kept", "bore"}}, {}, {}, ""}};
  m.scan_from_part = {1, 2, 3, radians(10), radians(20), radians(30)};
  conforms(m);
}

TEST_CASE("backends: a mesh of two bodies, one of them hollow") {
  TriSurface s;
  auto add_cube = [&](double low, double high, double shift, bool inward) {
    const auto first = static_cast<std::uint32_t>(s.vertices.size());
    for (int i = 0; i < 8; ++i)
      s.vertices.push_back({shift + (i & 1 ? high : low), i & 2 ? high : low, i & 4 ? high : low});
    for (std::array<std::uint32_t, 3> t : {std::array<std::uint32_t, 3>{0, 2, 1},
                                           {1, 2, 3},
                                           {4, 5, 6},
                                           {5, 7, 6},
                                           {0, 1, 4},
                                           {1, 5, 4},
                                           {2, 6, 3},
                                           {3, 6, 7},
                                           {0, 4, 2},
                                           {2, 4, 6},
                                           {1, 3, 5},
                                           {3, 7, 5}}) {
      if (inward) std::swap(t[1], t[2]);
      s.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
  };
  add_cube(0, 20, 0, false);
  add_cube(5, 15, 0, true);
  add_cube(0, 8, 40, false);
  const Model model = single("two_bodies", s);
  for (const auto& backend : own_backends) {
    INFO(backend);
    CHECK(volume(evaluated(emitted(model, backend), 0.1).mesh) == Approx(8000 - 1000 + 512));
  }
}

TEST_CASE("backends: volumes agree with formulas") {
  struct Known {
    const char* name;
    double volume;
  };
  const double eyes = 80 * 30 + pi * 15 * 15 - 2 * pi * 8 * 8;
  for (const Known& known :
       {Known{"box", 60 * 40 * 25.3}, Known{"wedge", (50 + 15) / 2.0 * 30 * 20}, Known{"cylinder", pi * 144 * 80},
        Known{"cone", pi * 35 / 3 * (400 + 100 + 25)}, Known{"torus", 2 * pi * pi * 30 * 64},
        Known{"ellipsoid", 4 * pi / 3 * 30 * 20 * 12}, Known{"tie_bar", eyes * 12}}) {
    for (const auto& backend : own_backends) {
      INFO(known.name << " " << backend);
      const double tolerance = round_all_over(golden(known.name)) ? 0.5 : 0.1;
      const TriangleMesh mesh = evaluated(emitted(golden(known.name), backend), tolerance).mesh;
      CHECK(std::abs(volume(mesh) - known.volume) < area(mesh) * tolerance / 20);
    }
  }
}

TEST_CASE("backends: an open sheet is covered, and OpenSCAD gets a closed solid of the named thickness") {
  const Model& model = golden("sheet");
  const auto& sheet = std::get<TriSurface>(model.objects.back().shape);
  for (const auto& backend : own_backends) {
    const Evaluation evaluation = evaluated(emitted(model, backend), model.tolerance);
    INFO(backend);
    CHECK_FALSE(evaluation.failed);
    CHECK(evaluation.solid == (backend == "openscad"));
    const MeshDistance distance(evaluation.mesh);
    for (const auto& t : sheet.triangles) {
      Vec3 center = Vec3::Zero();
      for (const auto v : t) center += Vec3(sheet.vertices[v][0], sheet.vertices[v][1], sheet.vertices[v][2]) / 3;
      CHECK(distance.closest(center).distance < 1e-4);
    }
  }
  TriangleMesh front;
  for (const auto& v : sheet.vertices) front.vertices.emplace_back(v[0], v[1], v[2]);
  front.triangles = sheet.triangles;
  const Evaluation solid = evaluated(emitted(model, "openscad"), model.tolerance);
  CHECK(volume(solid.mesh) == Approx(2 * area(front)).epsilon(0.03));
}

TEST_CASE("backends: an open surface is covered as far as its border, in each backend, OpenSCAD makes it a solid") {
  const Model& model = golden("cowl");
  const auto surfaces = trimmed_surfaces(cowl().patches);
  const SurfaceTriangles fine = triangulated(surfaces, 0.002);
  const ModelDistance to_model(model);
  for (const auto& backend : own_backends) {
    const Evaluation evaluation = evaluated(emitted(model, backend), model.tolerance);
    INFO(backend);
    CHECK_FALSE(evaluation.failed);
    CHECK(evaluation.solid == (backend == "openscad"));
    const MeshDistance distance(evaluation.mesh);
    double missed = 0, beyond = 0;
    for (const Vec3& p : fine.mesh.vertices) missed = std::max(missed, distance.closest(p).distance);
    CHECK(missed < 0.2 * model.tolerance);
    if (evaluation.solid) {
      CHECK(volume(evaluation.mesh) == Approx(2 * area(fine.mesh)).epsilon(0.05));
      continue;
    }
    CHECK(area(evaluation.mesh) == Approx(area(fine.mesh)).epsilon(1e-3));
    for (const Vec3& p : evaluation.mesh.vertices) beyond = std::max(beyond, std::abs(to_model(p).distance));
    CHECK(beyond < 0.2 * model.tolerance);
  }
}

TEST_CASE("backends: a control point that is moved in the script moves the surface") {
  const Artifact artifact = emitted(golden("cowl"), "openscad");
  Artifact edited = artifact;
  std::string& text = edited.files[0].bytes;
  const std::string point = "[30, 10, 14]";
  const auto at = text.find(point);
  REQUIRE(at != std::string::npos);
  text.replace(at, point.size(), "[30, 10, 19]");
  const double before = evaluated(artifact, 0.5).mesh.bounds().high.z(),
               after = evaluated(edited, 0.5).mesh.bounds().high.z();
  CHECK(after > before + 0.5);
  CHECK(after < before + 5);
}

TEST_CASE("backends: a part that is off by half the tolerance is noticed by the conformance measure") {
  Model spoiled = golden("pin");
  const ModelDistance truth(golden("pin"));
  for (auto& p : spoiled.parameters) {
    if (p.name == "shank_radius") p.value += spoiled.tolerance / 2;
  }
  for (const auto& backend : own_backends) {
    const Evaluation evaluation = evaluated(emitted(spoiled, backend), spoiled.tolerance);
    double worst = 0;
    for (const Vec3& v : evaluation.mesh.vertices) worst = std::max(worst, std::abs(truth(v).distance));
    INFO(backend);
    CHECK(worst > spoiled.tolerance / 5);
  }
}

TEST_CASE("iges: the boolean tree stands beside the body and names the steps") {
  const std::string text = emitted(golden("bracket"), "iges").files[0].bytes;
  CHECK(contains(text, "     180 "));
  CHECK(contains(text, "     186 "));
  for (const char* name : {"4Hfoot", "4Hwall", "6Hbore_1", "3Heye", "7Hbracket"}) CHECK(contains(text, name));
  CHECK_FALSE(contains(emitted(golden("superellipsoid"), "iges").files[0].bytes, "     180 "));
}

TEST_CASE("iges: an open free form is trimmed surfaces, each with its borders on the surface and in space") {
  // Entity 144 on a B-spline surface, 128; each border is 142 with a curve in the parameter plane, 126.
  const auto entities = [](const std::string& text) {
    std::map<int, int> count;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
      if (line.size() >= 80 && line[72] == 'D') ++count[std::stoi(line.substr(0, 8))];
    for (auto& [kind, twice] : count) twice /= 2;  // an entry has two lines
    return count;
  };
  const Model& model = golden("cowl");
  std::size_t loops = 0, curves = 0;
  const auto surfaces = trimmed_surfaces(cowl().patches);
  for (const auto& s : surfaces)
    for (const auto& loop : s.loops) ++loops, curves += loop.size();
  auto count = entities(emitted(model, "iges").files[0].bytes);
  CHECK(count[144] == static_cast<int>(surfaces.size()));
  CHECK(count[128] == static_cast<int>(surfaces.size()));
  CHECK(count[142] == static_cast<int>(loops));
  CHECK(count[126] >= static_cast<int>(curves));
  CHECK(loops > surfaces.size());  // it has a window
  CHECK(entities(emitted(golden("box"), "iges").files[0].bytes).count(144) == 0);
}

TEST_CASE("iges and step: no clock, user or machine in the file") {
  CHECK(contains(emitted(golden("box"), "iges").files[0].bytes, "19700101.000000"));
  CHECK(contains(emitted(golden("box"), "step").files[0].bytes, "1970-01-01T00:00:00"));
  CHECK(contains(emitted(golden("box"), "step").files[0].bytes, "PRODUCT('box','box'"));
}

TEST_CASE("openscad: a parameter is printed once, with its evidence") {
  const std::string script = script_of(golden("pin"));
  CHECK(contains(script, "shank_radius = as_designed ? 9 : 8.9987;"));
  CHECK(contains(script, "fitted 8.9987 +/- 0.0004 from 4,120 points; nominal 9 (0.5 mm grid, z = 3.3)"));
  CHECK(contains(
      script,
      "each arc([head_radius - fillet_radius, shank_length + head_height - fillet_radius], fillet_radius, 0, 90)"));
  CHECK(contains(script, "if (as_scanned) scan_from_part() part();"));
}

TEST_CASE("openscad: the as-built sizes run too, and give the fitted part") {
  Model model = golden("pin");
  Artifact artifact = emitted(model, "openscad");
  std::string& script = artifact.files[0].bytes;
  const std::string on = "as_designed = true;";
  REQUIRE(contains(script, on));
  script.replace(script.find(on), on.size(), "as_designed = false;");
  for (auto& p : model.parameters) p.value = p.fitted;
  const ModelDistance fitted(model);
  const Evaluation evaluation = evaluated(artifact, model.tolerance);
  CHECK_FALSE(evaluation.failed);
  double worst = 0;
  for (const Vec3& v : evaluation.mesh.vertices) worst = std::max(worst, std::abs(fitted(v).distance));
  CHECK(worst < model.tolerance / 5);
}

TEST_CASE("openscad: impossible sizes are refused by the script itself") {
  Artifact artifact = emitted(golden("cylinder"), "openscad");
  std::string& script = artifact.files[0].bytes;
  const std::string good = "radius = as_designed ? 12";
  REQUIRE(contains(script, good));
  script.replace(script.find(good), good.size(), "radius = as_designed ? -12");
  CHECK(evaluated(artifact, 0.5).failed);
}

TEST_CASE("openscad: expressions keep their meaning") {
  const Expr a = Expr::of("a"), b = Expr::of("b"), c = Expr::of("c"), t = Expr::of("t");
  const std::vector<Parameter> all = {parameter("a", 40), parameter("b", 7), parameter("c", 3),
                                      parameter("t", radians(30), Quantity::angle)};
  struct Said {
    Expr expr;
    std::string text;
  };
  using Kind = Expr::Kind;
  const std::vector<Said> table = {
      {Expr::call(Kind::subtract, {a, Expr::call(Kind::add, {b, c})}), "a - (b + c)"},
      {Expr::call(Kind::subtract, {Expr::call(Kind::subtract, {a, b}), c}), "a - b - c"},
      {Expr::call(Kind::divide, {a, Expr::call(Kind::multiply, {b, c})}), "a / (b * c)"},
      {Expr::call(Kind::multiply, {Expr::call(Kind::add, {a, b}), c}), "(a + b) * c"},
      {Expr::call(Kind::multiply, {a, Expr::call(Kind::sin, {t})}), "a * sin(t)"},
      {Expr::call(Kind::multiply, {a, Expr::call(Kind::cos, {Expr::call(Kind::multiply, {Expr(2), t})})}),
       "a * cos(2 * t)"},
      {Expr::call(Kind::multiply, {a, Expr::call(Kind::cos, {Expr(radians(45))})}), "a * cos(45)"},
      {Expr::call(Kind::multiply, {a, t}), "a * t * PI / 180"},
      {Expr::call(Kind::sqrt, {Expr::call(Kind::subtract, {Expr::call(Kind::multiply, {a, a}), b})}),
       "sqrt(a * a - b)"},
      {Expr::call(Kind::multiply, {b, Expr::call(Kind::asin, {Expr::call(Kind::divide, {b, a})})}),
       "b * asin(b / a) * PI / 180"},
      {Expr::call(Kind::subtract, {a, Expr::call(Kind::negate, {b})}), "a - (-b)"},
  };
  for (const Said& said : table) {
    const Model model = block_with(said.expr, all);
    const std::string script = script_of(model);
    INFO(said.text);
    CHECK(contains(script, "cube([" + said.text + ", 10, 10]);"));
    // The real program computes the same number.
    const Evaluation evaluation = evaluated(emitted(model, "openscad"), 0.1);
    CHECK_FALSE(evaluation.failed);
    CHECK(evaluation.mesh.bounds().size().x() == Approx(evaluate(said.expr, values_of(model))).epsilon(1e-6));
  }
}

TEST_CASE("openscad: angles are printed in degrees wherever they stand") {
  Model model = block_with(Expr(20), {parameter("tilt", radians(12.5), Quantity::angle)});
  model.objects[0].frame.rz = Expr::of("tilt") / Expr(2) + Expr(radians(90));
  const std::string script = script_of(model);
  CHECK(contains(script, "tilt = 12.5;"));
  CHECK(contains(script, "rotate([0, 0, tilt / 2 + 90])"));
}

TEST_CASE("openscad: names that OpenSCAD uses itself are spelled apart") {
  Model model = block_with(Expr::of("n"), {parameter("n", 20)});
  model.objects[0].name = "disc";
  const std::string script = script_of(model);
  CHECK(contains(script, "n_value = 20;"));
  CHECK(contains(script, "module disc_body()"));
}

TEST_CASE("openscad: notes cannot break out of their comments") {
  Model model = golden("box");
  model.parameters[0].note = "a note\nevil = 1;";
  model.objects.back().note = "first\r\nsecond";
  const std::string script = script_of(model);
  CHECK_FALSE(contains(script, "\nevil"));
  CHECK_FALSE(contains(script, "\nsecond"));
}

TEST_CASE("backends: bad requests are refused") {
  Context context;
  const CheckedModel model = checked_model(golden("box"));
  auto unknown = emit(model, "autocad", {}, context);
  REQUIRE_FALSE(unknown.ok());
  CHECK(unknown.error().kind == ErrorKind::usage);
  CHECK(contains(unknown.error().message, "expected a backend (openscad, alpha1, iges, step), found 'autocad'"));

  EmitOptions options;
  options.templates = "/nowhere/at/all";
  CHECK(contains(emit(model, "openscad", options, context).error().message, "expected a folder of template packs"));

  context.cancelled = true;
  CHECK(emit(model, "openscad", {}, context).error().kind == ErrorKind::stopped);
}

TEST_CASE("backends: a difference that leaves nothing is refused with the object's name") {
  Model model;
  model.name = "nothing";
  model.objects = {{"small", Box{10, 10, 10}, {}, {}, ""},
                   {"large", Box{30, 30, 30}, {-10, -10, -10, 0, 0, 0}, {}, ""},
                   {"rest", Difference{{"small", "large"}}, {}, {}, ""}};
  Context context;
  for (const auto& backend : {"iges", "step"}) {
    auto result = emit(checked_model(model), backend, {}, context);
    REQUIRE_FALSE(result.ok());
    CHECK(contains(result.error().message, "object 'rest': expected a body, found nothing left of it"));
  }
}

TEST_CASE("backends: a boundary that was written once is the same when it is written again") {
  for (const Model& model : golden_models()) {
    const CheckedModel checked = checked_model(model);
    EmitOptions shared;
    shared.brep = std::make_shared<SharedBrep>();
    Context context;
    for (const auto& backend : {"iges", "step"}) {
      const auto artifact = emit(checked, backend, shared, context);
      INFO(model.name << " " << backend);
      REQUIRE(artifact.ok());
      CHECK(artifact->files[0].bytes == emitted(model, backend).files[0].bytes);
    }
    CHECK(shared.brep->built.has_value());
  }
}

TEST_CASE("descriptions: numbers as a person writes them") {
  CHECK(with_thousands(0) == "0");
  CHECK(with_thousands(999) == "999");
  CHECK(with_thousands(4120) == "4,120");
  CHECK(with_thousands(1234567) == "1,234,567");
  Parameter p = parameter("r", 11);
  p.fitted = 10.99712;
  p.sigma = 0.0041;
  p.points = 4120;
  CHECK(describe_fit(p, 0.1) == "fitted 10.997 +/- 0.004 from 4,120 points");
  p.nominal = NominalEvidence{11, 0.7, true, "1 mm grid"};
  CHECK(describe_fit(p, 0.1) == "fitted 10.997 +/- 0.004 from 4,120 points; nominal 11 (1 mm grid, z = 0.7)");
  CHECK(as_built_text(p, 0.1) == "10.997");
  p.nominal->kept = false;
  p.value = 10.998;
  CHECK_FALSE(as_built_text(p, 0.1).has_value());
}

TEST_CASE("backends: patterns are loops over their count, parameters that follow from others are formulas") {
  const std::string script = script_of(golden("flange"));
  CHECK(contains(script, "bolts = 6;"));
  CHECK(contains(script, "bolt_circle_r = bolt_circle_d / 2;"));
  CHECK(contains(script, "bolt_step = 360 / bolts;"));
  CHECK(contains(script, "for (i = [0 : bolts - 1]) rotate([0, 0, i * bolt_step]) bolt_hole();"));
  CHECK(contains(script, "round_cutter(d = bore_d, from = -(thickness + hub_height) - 1, to = 1);"));
}

TEST_CASE("backends: a count edited in the script drills as many holes") {
  Artifact flange = emitted(golden("flange"), "openscad");
  const double six = volume(evaluated(flange, 0.1).mesh);
  std::string& script = flange.files[0].bytes;
  script.replace(script.find("bolts = 6;"), 10, "bolts = 4;");
  const double four = volume(evaluated(flange, 0.1).mesh);
  // A hole of 6.6 through 12 mm, and a countersink to 13.
  const double r = 3.3, R = 6.5, depth = R - r, cone = pi / 3 * depth * (R * R + R * r + r * r);
  CHECK(four - six == Approx(2 * (pi * r * r * (12 - depth) + cone)).epsilon(0.01));
}
