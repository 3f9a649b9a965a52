/// Claims about reading STEP and IGES in a process of its own: hostile files neither hang nor crash the verifier, and
/// files that contradict themselves are not believed.
#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <regex>

#include "core/number.h"
#include "core/sanitized.h"
#include "testing/meshes.h"
#include "testing/program.h"
#include "verify/exchange/brep_distance.h"

using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

std::string golden(const std::string& file) {
  const auto text = read_file(source_file("tests/golden/" + std::string(file)));
  REQUIRE(text.ok());
  return *text;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

struct Desk {
  TemporaryDirectory folder;
  Context context;

  Path put(const std::string& name, const std::string& text) {
    REQUIRE(write_file(folder.path() / name, text).ok());
    return folder.path() / name;
  }
  Path program(const std::string& name, const std::string& script) {
    const Path file = put(name, "#!/bin/sh\n" + script + "\n");
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
    return file;
  }
  Evaluation evaluate(const Path& file, const EvaluateOptions& options = {}) {
    auto result = evaluate_artifact(file, options, context);
    INFO((result.ok() ? "" : result.error().message));
    REQUIRE(result.ok());
    return *result;
  }
};

/// A torus in metres instead of millimetres: to mesh it to a hundredth of a millimetre takes hours and all memory.
std::string endless_torus() {
  return replaced(golden("torus/part.step"), "SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT($,.METRE.)");
}

/// The n-th point in space moved by `by` in x.
std::string point_moved(const std::string& text, std::size_t n, double by) {
  static const std::regex point(R"(CARTESIAN_POINT\('[^']*',\(([-0-9.E+]+),([-0-9.E+]+),\s*([-0-9.E+]+)\)\))");
  for (std::sregex_iterator m(text.begin(), text.end(), point), end; m != end; ++m)
    if (n-- == 0)
      return text.substr(0, std::size_t(m->position(0))) + "CARTESIAN_POINT('',(" +
             print_real(std::stod((*m)[1]) + by) + "," + (*m)[2].str() + "," + (*m)[3].str() + "))" +
             text.substr(std::size_t(m->position(0) + m->length(0)));
  return {};
}

}  // namespace

TEST_CASE("run occt: a file that takes too long is not run, in its time") {
  Desk desk;
  const Path file = desk.put("part.step", endless_torus());
  EvaluateOptions options;
  options.tolerance = 0.001, options.seconds = 1;
  const auto start = std::chrono::steady_clock::now();
  const auto slow = evaluate_artifact(file, options, desk.context);
  CHECK(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() < 5);
  REQUIRE_FALSE(slow.ok());
  CHECK(slow.error().kind == ErrorKind::stopped);
  CHECK(slow.error().message == "OpenCASCADE did not finish 'part.step' within 1 s");
}

TEST_CASE("run occt: a file that takes too much memory is not run") {
  if (partscribe::core::sanitized) return;  // memory is not limited then
  Desk desk;
  EvaluateOptions options;
  options.tolerance = 0.001, options.memory_mb = 600;
  const auto large = evaluate_artifact(desk.put("part.step", endless_torus()), options, desk.context);
  REQUIRE_FALSE(large.ok());
  CHECK(large.error().kind == ErrorKind::stopped);
  CHECK(large.error().message == "OpenCASCADE needs more than 600 MB for 'part.step'");
}

TEST_CASE("run occt: what does not finish is not run in the verdict, with exit code 4") {
  Desk desk;
  VerifyOptions options;
  options.seconds = 0.001;  // no program starts that fast
  const auto verdict = verify_artifacts({desk.put("part.step", golden("box/part.step"))},
                                        scanned(box({0, 0, 0}, {10, 10, 10}), 2000, 0), {}, options, desk.context);
  REQUIRE(verdict.ok());
  CHECK(verdict->verdict == Outcome::not_run);
  CHECK(exit_code_of(verdict->verdict) == 4);
  CHECK(all_reasons(*verdict).find("OpenCASCADE did not finish 'part.step'") != std::string::npos);
}

TEST_CASE("run occt: a procedure that takes too long is not run, in its time") {
  Desk desk;
  const Path file = desk.put("part.scl", "A : 0; while ( true ) A;");
  EvaluateOptions options;
  options.seconds = 0.01;
  const auto late = evaluate_artifact(file, options, desk.context);
  REQUIRE_FALSE(late.ok());
  CHECK(late.error().kind == ErrorKind::stopped);
  CHECK(late.error().message == "partscribe scl interpreter did not finish 'part.scl' within 0.01 s");
}

TEST_CASE("run occt: a file that crashes the reader is refused") {
  Desk desk;
  // Lists within lists, deeper than the stack of OpenCASCADE's parser.
  const std::size_t depth = 1000000;
  const std::string deep =
      replaced(golden("box/part.step"), "DATA;\n",
               "DATA;\n#900000=X(" + std::string(depth, '(') + "1." + std::string(depth, ')') + ");\n");
  const auto e = desk.evaluate(desk.put("part.step", deep));
  CHECK(e.failed);
  REQUIRE(e.complaints.size() == 1);
  CHECK(e.complaints[0] == "OpenCASCADE crashed over the file, by signal 11");
  CHECK(e.mesh.empty());
}

TEST_CASE("run occt: a reader that is missing, foreign or of another version is no fault of the file") {
  Desk desk;
  const Path file = desk.put("part.step", golden("box/part.step"));
  auto kind_with = [&](const Path& reader) {
    EvaluateOptions options;
    options.reader = reader;
    const auto result = evaluate_artifact(file, options, desk.context);
    REQUIRE_FALSE(result.ok());
    return result.error().kind;
  };
  CHECK(kind_with(desk.folder.path() / "nowhere") == ErrorKind::missing_program);
  CHECK(kind_with(desk.program("foreign", "echo 'unknown command' >&2; exit 2")) == ErrorKind::missing_program);
  CHECK(kind_with(desk.program("newer", "echo 'partscribe brep 2' > $4")) == ErrorKind::missing_program);
  EvaluateOptions options;
  options.reader = desk.program("crashing", "kill -SEGV $$");
  CHECK(desk.evaluate(file, options).failed);
}

TEST_CASE("run occt: exact surfaces come back from the reader") {
  Desk desk;
  const auto e = desk.evaluate(desk.put("part.step", golden("cone/part.step")));
  REQUIRE(e.exact);
  for (const auto& v : e.mesh.vertices) CHECK(std::abs(e.exact->closest(v).distance) < 1e-6);
  CHECK(e.gap.width < 1e-6);
}

TEST_CASE("run occt: a file whose points contradict its surfaces is refused, whatever the reader makes of it") {
  Desk desk;
  const std::string cone = golden("cone/part.step");
  const Path good = desk.put("good.step", cone);
  const TriangleMesh truth = desk.evaluate(good).mesh;
  const auto scan = scanned(truth, 20000, 0);
  auto outcome = [&](const std::string& text, std::string& reasons) {
    const auto verdict = verify_artifacts({desk.put("part.step", text)}, scan, {}, {}, desk.context);
    REQUIRE(verdict.ok());
    reasons = all_reasons(*verdict);
    return verdict->verdict;
  };
  std::string reasons;
  CHECK(outcome(cone, reasons) == Outcome::verified);
  // Vertex 1 of the rim: OpenCASCADE delivers the true body all the same, with a tolerance of 0.8 mm.
  const std::string spoilt = point_moved(cone, 1, 0.8);
  CHECK(desk.evaluate(desk.put("spoilt.step", spoilt)).gap.width == Approx(0.8).epsilon(0.01));
  CHECK(outcome(spoilt, reasons) == Outcome::out_of_tolerance);
  INFO(reasons);
  CHECK(reasons.find("the file contradicts itself: its curves and faces miss one another by 0.8 mm at the vertex") !=
        std::string::npos);
  CHECK(outcome(point_moved(cone, 1, 0.03), reasons) == Outcome::cannot_decide);
  CHECK(reasons.find("the file itself is only good to 0.03 mm at the vertex") != std::string::npos);
  CHECK(outcome(point_moved(cone, 1, 0.01), reasons) == Outcome::verified);
}
