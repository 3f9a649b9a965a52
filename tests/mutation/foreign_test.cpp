/// Scripts that we did not write: no model beside them, other habits. One number edited is refused, and the place is
/// named.
#include <algorithm>
#include <catch2/catch.hpp>

#include "core/files.h"
#include "core/random.h"
#include "scan/simulate/simulate.h"
#include "testing/damage/file_damage.h"
#include "testing/damage/suite.h"
#include "testing/program.h"
#include "verify/evaluate/evaluate.h"

using namespace partscribe::scan;
using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

constexpr double T = 0.2;

struct TextEdit {
  std::string from, to;
  bool harmless = false;
  std::string names = "";  ///< what the name of the worst feature begins with
};

std::string script(const std::string& name) {
  const auto text = read_file(source_file("tests/mutation/scripts/" + std::string(name)));
  REQUIRE(text.ok());
  return *text;
}

TriangleMesh evaluated(const Path& file) {
  Context context;
  const auto evaluation = evaluate_artifact(file, {T}, context);
  REQUIRE(evaluation.ok());
  INFO((evaluation->complaints.empty() ? "" : evaluation->complaints[0]));
  CHECK(evaluation->solid);
  return evaluation->mesh;
}

void edits_of(const std::string& name, const std::vector<TextEdit>& edits) {
  const std::string text = script(name);
  const TemporaryDirectory folder;
  const Path file = folder.path() / name;
  REQUIRE(write_file(file, text).ok());
  const TriangleMesh truth = evaluated(file);
  Context context;
  context.threads = 2;
  SimulateOptions options;
  options.views = "icosahedron";
  options.resolution = 96;
  options.sigma = 0.2 * T;
  options.outliers = 0.005;
  const Scan scan = simulate(surface_of(truth), options, context).merged;
  for (const auto& edit : edits) {
    const std::string edited = edit.from.empty() ? text : with_all(text, edit.from, edit.to);
    INFO(name << ": " << edit.from << " -> " << edit.to);
    if (!edit.from.empty()) REQUIRE(edited != text);
    REQUIRE(write_file(file, edited).ok());
    VerifyOptions how;
    how.tolerance = T;
    const auto verdict = verify_artifacts({file}, scan, std::nullopt, how, context);
    REQUIRE(verdict.ok());
    const auto& a = verdict->artifacts[0];
    std::string words;
    for (const auto& r : a.reasons) words += r + "\n";
    for (const auto& f : a.findings) words += f.text + "\n";
    INFO(words);
    if (edit.harmless) {
      CHECK(verdict->verdict == Outcome::verified);
      continue;
    }
    CHECK(verdict->verdict == Outcome::out_of_tolerance);
    REQUIRE(!a.findings.empty());
    const Finding& worst = a.findings[0];
    CHECK(worst.kind != Finding::Kind::not_scanned);
    CHECK(!worst.feature.empty());
    if (!edit.names.empty()) CHECK(worst.feature.rfind(edit.names, 0) == 0);
    double nearest = 1e9;
    for (const auto& p : harm_between(truth, a.mesh, T).places) nearest = std::min(nearest, (p - worst.place).norm());
    CHECK(nearest < 4);
  }
}

}  // namespace

TEST_CASE("foreign script: a bearing stand with an edited dimension is refused where it was edited") {
  edits_of("bearing_stand.scad", {
                                     {"", "", true},
                                     {"screw_d", "bolt_diameter", true},
                                     {"    ", "\t", true},
                                     {"d = 15,", "d = 15.02,", true},
                                     {"d = 15,", "d = 15.8,", false, "hole"},
                                     {"screw_gap = 48", "screw_gap = 48.8", false, "hole"},
                                     {"n_screws = 2", "n_screws = 1"},
                                     {"translate([0, 3, 5])", "translate([0, 3.4, 5])"},
                                     {"height = 30", "height = 30.4"},
                                     {"base = [64, 36, 7]", "base = [64, 36, 7.4]"},
                                 });
}

TEST_CASE("foreign script: a knob with an edited dimension is refused where it was edited") {
  edits_of("knob.scad", {
                            {"", "", true},
                            {";", ";  // checked\n", true},
                            {"grips=6", "grips=5"},
                            {"body_h=14", "body_h=14.4"},
                            {"d=6.6", "d=7.4", false, "hole"},
                            {"body_h-6", "body_h-6.4"},
                            {"  nut();\n", ""},
                        });
}

TEST_CASE("foreign script: a lid whose rounding was removed is refused at its corners") {
  edits_of("lid.scad", {
                           {"", "", true},
                           {"pins(2, 3, 16)", "pins(rows = 2, columns = 3, pitch = 16)", true},
                           {"pins(2, 3, 16)", "pins(2, 2, 16)"},
                           {"pins(2, 3, 16)", "pins(2, 3, 16.4)"},
                           {"wall = 2.4", "wall = 2.8"},
                           {"minkowski()", "union()"},
                           {"h = 5.5", "h = 5.9"},
                       });
}
