/// Alpha_1 procedures: what is written is what was committed, and our interpreter makes the model's geometry of it.
///
/// PARTSCRIBE_WRITE_GOLDENS=1 rewrites tests/golden and ends red: regenerating is not verifying.
#include "codegen/alpha1/alpha1.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>

#include "codegen/alpha1/alpha1_superellipsoid.h"
#include "core/number.h"
#include "core/random.h"
#include "model/distance/distance.h"
#include "model/json.h"
#include "testing/golden_models.h"
#include "testing/program.h"
#include "verify/evaluate/run_occt.h"

using namespace partscribe::codegen;
using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

Artifact emitted(const Model& model) {
  Context context;
  auto sound = checked(model, model.name);
  if (!sound.ok()) FAIL(sound.error().message);
  auto artifact = emit_alpha1(*sound, {}, context);
  if (!artifact.ok()) FAIL(artifact.error().message);
  return std::move(artifact).value();
}

Evaluation evaluated(const Artifact& artifact, double tolerance) {
  TemporaryDirectory folder;
  for (const auto& file : artifact.files) REQUIRE(write_file(folder.path() / file.name, file.bytes).ok());
  Context context;
  auto evaluation = evaluate_alpha1(folder.path() / artifact.files[0].name, {.tolerance = tolerance}, context);
  if (!evaluation.ok()) FAIL(evaluation.error().message);
  return std::move(evaluation).value();
}

Evaluation sound_evaluation(const Model& model) {
  const Evaluation e = evaluated(emitted(model), model.tolerance);
  for (const auto& c : e.complaints) UNSCOPED_INFO(c);
  CHECK(e.complaints.empty());
  CHECK_FALSE(e.failed);
  REQUIRE_FALSE(e.mesh.empty());
  return e;
}

const Model& golden(const std::string& name) {
  static const std::vector<Model> all = golden_models();
  return *std::find_if(all.begin(), all.end(), [&](const Model& m) { return m.name == name; });
}

/// Largest distance of points of the mesh from the model.
double deviation(const TriangleMesh& mesh, const ModelDistance& distance) {
  double worst = 0;
  const std::size_t step = std::max<std::size_t>(1, mesh.triangles.size() / 10000);
  for (std::size_t t = 0; t < mesh.triangles.size(); t += step) {
    const Vec3 a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
    for (const Vec3& p : {a, Vec3(0.5 * a + 0.3 * b + 0.2 * c), Vec3(0.46 * a + 0.54 * b)})
      worst = std::max(worst, std::abs(distance(p).distance));
  }
  return worst;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  INFO("looking for " << from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

Model one_object(const Shape& shape, std::vector<Parameter> parameters = {}) {
  Model m;
  m.name = "part";
  m.parameters = std::move(parameters);
  Object o;
  o.name = "body";
  o.shape = shape;
  m.objects.push_back(o);
  return m;
}

Parameter parameter(const std::string& name, double value, Quantity quantity = Quantity::length) {
  Parameter p;
  p.name = name;
  p.value = p.fitted = value;
  p.quantity = quantity;
  return p;
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("alpha1 goldens: the committed model gives exactly the committed procedure and prelude") {
  const bool rewrite = std::getenv("PARTSCRIBE_WRITE_GOLDENS") != nullptr;
  for (const Model& made : golden_models()) {
    INFO(made.name);
    const Path folder = source_file("tests/golden/" + made.name);
    auto text = read_file(folder / "model.json");
    REQUIRE(text.ok());
    auto model = read_model_json(*text, made.name);
    REQUIRE(model.ok());
    const Artifact artifact = emitted(*model);
    REQUIRE(artifact.files.size() == 2);
    CHECK(artifact.backend == "alpha1");
    CHECK(artifact.files[0].name == "part.scl");
    CHECK(artifact.files[1].name == "prelude.scl");
    for (const auto& file : artifact.files) {
      if (rewrite) REQUIRE(write_file(folder / file.name, file.bytes).ok());
      auto committed = read_file(folder / file.name);
      REQUIRE(committed.ok());
      CHECK(*committed == file.bytes);
    }
  }
  if (rewrite) FAIL("the goldens were rewritten; run again without PARTSCRIBE_WRITE_GOLDENS to verify them");
}

TEST_CASE("alpha1: every shape, run by the interpreter, lies on the model within a fifth of the tolerance") {
  for (Model model : golden_models()) {
    if (is_sheet(model.objects.back().shape)) continue;
    INFO(model.name);
    const Evaluation e = sound_evaluation(model);
    CHECK(e.solid);
    CHECK(e.error <= model.tolerance / 5);
    const ModelDistance distance(model);
    CHECK(deviation(e.mesh, distance) <= model.tolerance / 5);
    // A missing face or body shows in the volume: the share of the box that is inside says what it should be.
    const Box3 box = e.mesh.bounds();
    Random random(7);
    const int tries = 60000;
    int inside = 0;
    for (int i = 0; i < tries; ++i) {
      const Vec3 p(random.uniform(box.low.x(), box.high.x()), random.uniform(box.low.y(), box.high.y()),
                   random.uniform(box.low.z(), box.high.z()));
      inside += distance(p).distance < 0;
    }
    const double whole = box.size().prod(), share = double(inside) / tries;
    CHECK(volume(e.mesh) ==
          Approx(share * whole).margin(5 * whole * std::sqrt(share * (1 - share) / tries) + 1e-3 * whole));
  }
}

TEST_CASE("alpha1: volumes agree with formulas") {
  const std::vector<std::pair<const char*, double>> known = {
      {"box", 60 * 40 * 25.3},
      {"wedge", (50 + 15) / 2.0 * 30 * 20},
      {"cylinder", pi * 144 * 80},
      {"cone", pi * 35 / 3 * (400 + 100 + 25)},
      {"torus", 2 * pi * 30 * pi * 64},
      {"ellipsoid", 4.0 / 3 * pi * 30 * 20 * 12},
      {"tie_bar", 12 * (80 * 30 + pi * 225 - 2 * pi * 64)},
  };
  for (const auto& [name, expected] : known) {
    Model model = golden(name);
    model.tolerance = 0.05;
    INFO(name);
    CHECK(volume(sound_evaluation(model).mesh) == Approx(expected).epsilon(2e-3));
  }
}

TEST_CASE("alpha1: an open sheet stays a sheet with the area of its triangles") {
  const Model& model = golden("sheet");
  const Evaluation e = sound_evaluation(model);
  CHECK_FALSE(e.solid);
  const auto& s = std::get<TriSurface>(model.objects.back().shape);
  TriangleMesh mesh;
  for (const auto& v : s.vertices) mesh.vertices.push_back({v[0], v[1], v[2]});
  mesh.triangles = s.triangles;
  CHECK(area(e.mesh) == Approx(area(mesh)));
}

TEST_CASE("alpha1: an edited number gives another part, exactly as it says") {
  Artifact artifact = emitted(golden("cylinder"));
  const double before = volume(evaluated(artifact, 0.05).mesh);
  artifact.files[0].bytes = replaced(artifact.files[0].bytes, "if ( AsDesigned ) 12.0;", "if ( AsDesigned ) 13.0;");
  const double after = volume(evaluated(artifact, 0.05).mesh);
  CHECK(after / before == Approx(169.0 / 144).epsilon(1e-3));
}

TEST_CASE("alpha1: the switches choose the fitted sizes and the part's own frame") {
  Artifact artifact = emitted(golden("box"));
  const Evaluation scanned = evaluated(artifact, 0.1);
  Artifact own = artifact;
  own.files[0].bytes = replaced(own.files[0].bytes, "AsScanned : true;", "AsScanned : false;");
  const Evaluation at_home = evaluated(own, 0.1);
  CHECK((at_home.mesh.bounds().high - Vec3(60, 40, 25.3)).norm() < 1e-9);
  CHECK((scanned.mesh.bounds().high - Vec3(60, 40, 25.3)).norm() > 1);
  CHECK(volume(scanned.mesh) == Approx(volume(at_home.mesh)));
  own.files[0].bytes = replaced(own.files[0].bytes, "AsDesigned : true;", "AsDesigned : false;");
  CHECK(evaluated(own, 0.1).mesh.bounds().high.x() == Approx(60.012).margin(1e-9));
}

TEST_CASE("alpha1: damaged procedures are refused, never guessed") {
  const Artifact good = emitted(golden("bracket"));
  const std::vector<std::pair<std::string, std::string>> damages = {
      {"rightCirCylinder( Origin", "rightCirCylinder( Origen"},
      {"solidUnion(", "solidUnite("},
      {"BoreRadius :", "BoreRadius "},
      {" );", " ;"},
      {"include \"prelude.scl\";", "include \"missing.scl\";"},
      {"; else ", "; "},
      {"vec( ", "vec( \""},
  };
  for (const auto& [from, to] : damages) {
    Artifact bad = good;
    bad.files[0].bytes = replaced(bad.files[0].bytes, from, to);
    const Evaluation e = evaluated(bad, 0.1);
    INFO(from << " -> " << to);
    CHECK(e.failed);
    CHECK(e.mesh.empty());
    REQUIRE_FALSE(e.complaints.empty());
    CHECK(contains(e.complaints[0], "part.scl:"));
  }
}

TEST_CASE("alpha1: labels are CamelCase, never collide and never hide a word of SCL") {
  Model m = one_object(Box{Expr::of("facet"), Expr::of("bore_1_2"), Expr::of("bore_12") + Expr::of("r")},
                       {parameter("facet", 1), parameter("bore_1_2", 2), parameter("bore_12", 3), parameter("r", 4),
                        parameter("quartic", 5)});
  m.objects.insert(m.objects.begin(), Object{"blank", Sphere{1}, {}, {}, ""});
  m.objects.back().name = "bore_1_2b";
  const std::string text = emitted(m).files[0].bytes;
  CHECK(contains(text, "Facet_2 : 1.0;"));
  CHECK(contains(text, "Bore1_2 : 2.0;"));
  CHECK(contains(text, "Bore12 : 3.0;"));
  CHECK(contains(text, "R_2 : 4.0;"));
  CHECK(contains(text, "Quartic_2 : 5.0;"));
  CHECK(contains(text, "vec( 0.0, 0.0, Bore12 + R_2 )"));
  CHECK(volume(evaluated(emitted(m), 0.1).mesh) == Approx(1 * 2 * 7));
}

TEST_CASE(
    "alpha1: angles are degrees, reals have a point, and functions SCL may not have become numbers with a remark") {
  Model m = one_object(
      Box{2 * Expr::of("size"), Expr::call(Expr::Kind::sqrt, {Expr::of("size")}), 1e-7 + Expr::of("size") / 4},
      {parameter("size", 9), parameter("tilt", radians(30), Quantity::angle)});
  m.objects.back().frame = {5,
                            0,
                            -Expr::of("size"),
                            2 * Expr::of("tilt") - radians(15),
                            0,
                            Expr::call(Expr::Kind::atan2, {3, Expr::of("size")})};
  const std::string text = emitted(m).files[0].bytes;
  CHECK(contains(text, "Tilt : 30.0;"));
  CHECK(contains(text, "2.0 * Tilt - 15.0"));
  CHECK(contains(text, "vec( 2.0 * Size, 0.0, 0.0 )"));
  CHECK(contains(text, "# Where the parameters stand now, 3.0 is sqrt( Size )."));
  CHECK(contains(text, "18.4349488229 degrees is atan2( 3.0, Size )."));
  const Evaluation e = sound_evaluation(m);
  CHECK(volume(e.mesh) == Approx(18 * 3 * 2.25).epsilon(1e-6));
  CHECK(deviation(e.mesh, ModelDistance(m)) < 1e-6);
}

TEST_CASE("alpha1: the net of a superellipsoid stays within what was asked, at every squareness") {
  Random random(3);
  for (const double e1 : {0.2, 0.5, 1.0, 1.6}) {
    for (const double e2 : {0.15, 1.0, 1.9}) {
      const SuperellipsoidOf<double> s{20, 14, 9, e1, e2, 0.2, -0.3};
      const auto net = superellipsoid_net(s, 0.05);
      INFO(e1 << " " << e2);
      CHECK(net.deviation <= 0.05);
      CHECK(net.around.size() % 4 == 0);
    }
  }
  CHECK(superellipsoid_net({9, 11, 40, 0.5, 0.7, 0.2, -0.3, 1.3}, 0.05).deviation <= 0.05);
  CHECK(superellipsoid_net({9, 11, 40, 1.4, 1.2, 0.2, -0.3, -1.3}, 0.05).deviation <= 0.05);
}
