/// Scan to verdict on simulated parts, as a user runs it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "core/number.h"
#include "core/random.h"
#include "geometry/vec.h"
#include "testing/json_schema.h"
#include "testing/program.h"

namespace partscribe::testing {

using namespace geometry;

namespace {

double value_of(const nlohmann::json& model, const std::string& name) {
  for (const auto& parameter : model.at("parameters"))
    if (parameter.at("name") == name) return parameter.at("value");
  FAIL("no parameter " << name);
  return 0;
}

/// A parameter of either model that has this value within `slack`; the fit chooses the names.
bool has_value(const nlohmann::json& model, double value, double slack) {
  for (const auto& parameter : model.at("parameters"))
    if (std::abs(parameter.at("value").get<double>() - value) <= slack) return true;
  return false;
}

/// A noisy half-open look at a cylinder: enough to fit, quick to build.
std::string cylinder_xyz(std::uint64_t seed, bool shuffled) {
  Random random(seed);
  std::vector<std::string> lines;
  auto add = [&](double x, double y, double z) {
    lines.push_back(print_number(snapped(x, 1e-4)) + " " + print_number(snapped(y, 1e-4)) + " " +
                    print_number(snapped(z, 1e-4)) + "\n");
  };
  for (int i = 0; i < 6000; ++i) {
    const double a = random.uniform(0, 2 * pi), r = 8 + 0.005 * random.normal();
    add(r * std::cos(a), r * std::sin(a), random.uniform(0, 20));
  }
  for (int i = 0; i < 4000; ++i) {
    const double a = random.uniform(0, 2 * pi), r = 8 * std::sqrt(random.uniform());
    add(r * std::cos(a), r * std::sin(a), (i % 2) * 20 + 0.005 * random.normal());
  }
  if (shuffled)
    for (std::size_t i = lines.size(); i > 1; --i) std::swap(lines[i - 1], lines[random.below(i)]);
  std::string text;
  for (const auto& line : lines) text += line;
  return text;
}

/// The parameter with the largest value.
nlohmann::json longest_of(const nlohmann::json& model) {
  const auto& all = model.at("parameters");
  return *std::max_element(all.begin(), all.end(),
                           [](const auto& a, const auto& b) { return a.at("value") < b.at("value"); });
}

const std::vector<std::string> compared = {"model.json", "part.scad", "part.scl", "part.igs", "part.step"};

}  // namespace

TEST_CASE("corpus: the pin is found as a surface of revolution with its sizes, and verified") {
  const TemporaryDirectory folder;
  simulate_part("pin", folder.path() / "scan", 128, 0.01);
  const Path out = folder.path() / "out";
  const auto output = run_partscribe({"build", (folder.path() / "scan/scan.json").string(), "--tolerance", "0.1",
                                      "--name", "pin", "--out", out.string()});
  INFO(output.out << output.err);
  CHECK(output.exit_code == 0);
  for (const char* file : {"cloud.ply", "model.json", "part.scad", "part.scl", "prelude.scl", "part.igs", "part.step",
                           "verdict.json", "report.html"})
    CHECK(std::filesystem::is_regular_file(out / file));
  const auto model = nlohmann::json::parse(bytes_of(out / "model.json"));
  CHECK(model.at("objects").back().at("shape").at("kind") == "revolve");
  for (const double size : {12.0, 20.0}) CHECK(has_value(model, size, 0.02));
  const auto verdict = nlohmann::json::parse(bytes_of(out / "verdict.json"));
  CHECK(verdict.at("verdict") == "verified");
  CHECK(verdict.at("artifacts").size() == 4);
  CHECK(bytes_of(out / "report.html").size() < 5'000'000);
  // Rows are called as the parameters of their faces are.
  const auto has_row = [&](const char* row) {
    const auto& rows = verdict.at("artifacts").front().at("objects");
    return std::any_of(rows.begin(), rows.end(), [&](const auto& r) { return r.at("name") == row; });
  };
  value_of(model, "chamfer"), value_of(model, "shank_d");
  for (const char* row : {"chamfer", "shank", "head"}) CHECK(has_row(row));
  CHECK_FALSE(has_row("cone"));

  // An edit by hand beyond the tolerance must turn the verdict red.
  const std::string script = bytes_of(out / "part.scad");
  std::string edited = script;
  std::string name;
  for (const auto& parameter : model.at("parameters"))
    if (std::abs(parameter.at("value").get<double>() - 20) < 0.02) name = parameter.at("name");
  const auto at = edited.find("\n" + name + " = ");
  REQUIRE(at != std::string::npos);
  edited.replace(at, edited.find(';', at) - at, "\n" + name + " = " + print_number(value_of(model, name) + 0.3));
  REQUIRE(write_file(out / "part.scad", edited).ok());
  const auto again = run_partscribe({"verify", (out / "part.scad").string(), (out / "cloud.ply").string(), "--json"});
  CHECK(again.exit_code == 1);
  CHECK(nlohmann::json::parse(again.out).at("verdict") == "out_of_tolerance");
}

TEST_CASE("corpus: the tie bar is found as an extrusion with two holes, and verified") {
  const TemporaryDirectory folder;
  simulate_part("tie_bar", folder.path() / "scan", 128, 0.02);
  const Path out = folder.path() / "out";
  const auto output = run_partscribe({"build", (folder.path() / "scan/scan.json").string(), "--tolerance", "0.2",
                                      "--name", "tie_bar", "--out", out.string(), "--to", "openscad,step"});
  INFO(output.out << output.err);
  CHECK(output.exit_code == 0);
  const auto model = nlohmann::json::parse(bytes_of(out / "model.json"));
  CHECK(model.at("objects").back().at("shape").at("kind") == "extrude");
  for (const double size : {30.0, 16.0, 10.0, 12.0}) CHECK(has_value(model, size, 0.03));
}

TEST_CASE("corpus: a carton that was really scanned is a box with its sizes, verified, and no other box is") {
  const TemporaryDirectory folder;
  const std::string scan = source_file("corpus/carton/scan/carton.ply").string();
  const Path out = folder.path() / "out";
  const auto output = run_partscribe({"build", scan, "--units", "mm", "--tolerance", "2.5", "--procedure", "box",
                                      "--to", "openscad,step", "--out", out.string()});
  INFO(output.out << output.err);
  CHECK(output.exit_code == 0);
  const auto model = nlohmann::json::parse(bytes_of(out / "model.json"));
  CHECK(model.at("objects").back().at("shape").at("kind") == "box");
  // What planes through the middles of its sides say, which nobody fitted with this program; the sides bulge by a mm.
  for (const double size : {28.0, 71.1, 87.8}) CHECK(has_value(model, size, 1));
  const auto mass = run_partscribe({"analyse", out.string(), "--quick", "--json"});
  CHECK(nlohmann::json::parse(mass.out).at("volume").get<double>() == Approx(172983).epsilon(0.04));

  // The same box, longer by twice the tolerance.
  const auto longest = longest_of(model);
  double volume = nlohmann::json::parse(mass.out).at("volume").get<double>();
  volume *= 1 + 5 / longest.at("value").get<double>();
  const auto longer = run_partscribe({"analyse", out.string(), "--quick", "--target",
                                      "volume=" + print_number(snapped(volume, 1)) + "mm3", "--by", longest.at("name"),
                                      "--out", (folder.path() / "longer.json").string()});
  INFO(longer.err);
  REQUIRE(longer.exit_code == 0);
  REQUIRE(run_partscribe({"emit", (folder.path() / "longer.json").string(), "--to", "openscad", "--out",
                          (folder.path() / "longer").string()})
              .exit_code == 0);
  const auto verdict = run_partscribe(
      {"verify", (folder.path() / "longer/part.scad").string(), scan, "--units", "mm", "--tolerance", "2.5", "--json"});
  CHECK(verdict.exit_code == 1);
  CHECK(nlohmann::json::parse(verdict.out).at("verdict") == "out_of_tolerance");
}

TEST_CASE(
    "corpus: range images can be filtered before the fit, which then sees what was measured without flipped bits") {
  const TemporaryDirectory folder;
  const std::string shape = source_file("tests/golden/cylinder/part.step").string();
  const Path scan = folder.path() / "scan";
  const auto simulated = run_partscribe({"simulate", shape, "--bit-error", "0.04", "--sigma", "0.02", "--resolution",
                                         "96", "--no-merged", "--out", scan.string()});
  INFO(simulated.err);
  REQUIRE(simulated.exit_code == 0);
  std::map<std::string, nlohmann::json> models;
  for (const std::string filter : {"rlts", "profile", "none"}) {
    const Path out = folder.path() / filter;
    const auto output = run_partscribe({"build", (scan / "scan.json").string(), "--tolerance", "0.2", "--to",
                                        "openscad", "--filter", filter, "--out", out.string()});
    INFO(filter << ": " << output.out << output.err);
    CHECK((output.out.find("returns of range images as outliers") != std::string::npos) == (filter != "none"));
    const bool fitted = std::filesystem::exists(out / "model.json");
    REQUIRE((fitted || filter == "none"));
    if (!fitted) continue;
    models[filter] = nlohmann::json::parse(bytes_of(out / "model.json"));
    if (filter == "none") continue;
    CHECK(output.exit_code == 0);
    CHECK(has_value(models[filter], 24, 0.1));
  }
  // Errors of a code's low bits look like noise, so that fewer are rejected than were made.
  const auto& provenance = models["rlts"].at("provenance");
  const double share = provenance.at("rejected").get<double>() / provenance.at("points").get<double>();
  CHECK(share > 0.015);
  CHECK(share < 0.06);
}

TEST_CASE("corpus: the order of points and the number of threads change no byte") {
  const TemporaryDirectory folder;
  for (const char* sub : {"a", "b"}) std::filesystem::create_directory(folder.path() / sub);
  REQUIRE(write_file(folder.path() / "a/rod.xyz", cylinder_xyz(5, false)).ok());
  REQUIRE(write_file(folder.path() / "b/rod.xyz", cylinder_xyz(5, true)).ok());
  const auto build = [&](const std::string& sub, const std::string& out, const std::string& threads) {
    const auto output =
        run_partscribe({"build", (folder.path() / sub / "rod.xyz").string(), "--tolerance", "0.1", "--units", "mm",
                        "--threads", threads, "--out", (folder.path() / out).string()});
    INFO(output.out << output.err);
    CHECK(output.exit_code == 0);
  };
  build("a", "one", "1");
  build("a", "two", "2");
  build("b", "three", "2");
  for (const auto& file : compared) {
    INFO(file);
    CHECK(bytes_of(folder.path() / "one" / file) == bytes_of(folder.path() / "two" / file));
  }
  // The input's checksum is in the provenance, so the models differ there and nowhere else.
  const auto without_sources = [&](const std::string& out) {
    auto model = nlohmann::json::parse(bytes_of(folder.path() / out / "model.json"));
    model.at("provenance").erase("sources");
    return model;
  };
  CHECK(without_sources("one") == without_sources("three"));
  for (const auto& file : compared)
    if (file != "model.json") CHECK(bytes_of(folder.path() / "one" / file) == bytes_of(folder.path() / "three" / file));
}

TEST_CASE("corpus: a tolerance below what the scan can decide ends with 6, never with a pass") {
  const TemporaryDirectory folder;
  REQUIRE(write_file(folder.path() / "rod.xyz", cylinder_xyz(6, false)).ok());
  const auto output =
      run_partscribe({"build", (folder.path() / "rod.xyz").string(), "--units", "mm", "--tolerance", "0.005",
                      "--procedure", "cylinder", "--to", "step", "--out", (folder.path() / "out").string()});
  INFO(output.out << output.err);
  CHECK(output.exit_code == 6);
}

TEST_CASE("corpus: the single stages write what build writes") {
  const TemporaryDirectory folder;
  REQUIRE(write_file(folder.path() / "rod.xyz", cylinder_xyz(7, false)).ok());
  const std::string out = (folder.path() / "rod-partscribe").string();
  const auto step = [&](std::vector<std::string> arguments) {
    const auto output = run_partscribe(arguments, folder.path());
    INFO(arguments.front() << ": " << output.out << output.err);
    CHECK(output.exit_code == 0);
    return output;
  };
  step({"scan", "rod.xyz", "--units", "mm"});
  step({"fit", out + "/cloud.ply", "--tolerance", "0.1"});
  step({"emit", out + "/model.json", "--to", "openscad,step"});
  step({"verify", out + "/part.scad", out + "/part.step", out + "/cloud.ply", "--json", out + "/verdict.json", "--csv",
        out + "/verdict.csv", "--junit", out + "/verdict.xml"});
  step({"report", out, "--pictures", out});
  for (const char* file : {"cloud.ply", "poses.json", "model.json", "part.scad", "part.step", "verdict.json",
                           "verdict.csv", "verdict.xml", "report.html", "deviation.png", "front.png"})
    CHECK(std::filesystem::is_regular_file(Path(out) / file));
}

TEST_CASE("corpus: with --json standard output holds what was found, written and judged, and nothing else") {
  const TemporaryDirectory folder;
  REQUIRE(write_file(folder.path() / "rod.xyz", cylinder_xyz(8, false)).ok());
  const auto output = run_partscribe({"build", (folder.path() / "rod.xyz").string(), "--json", "--units", "mm", "--to",
                                      "step", "--out", (folder.path() / "out").string()});
  INFO(output.out << output.err);
  CHECK(output.exit_code == 0);
  const auto json = nlohmann::json::parse(output.out);
  CHECK(JsonSchema(source_file("docs/verdict.schema.json")).fault(json, JsonSchema::Keys::named) == "");
  CHECK(json.at("verdict") == "verified");
  CHECK(json.at("artifacts").size() == 1);
  CHECK(json.at("procedure") == "cylinder");
  CHECK(json.at("fallback") == false);
  const auto model = nlohmann::json::parse(bytes_of(folder.path() / "out/model.json"));
  CHECK(json.at("parameters") == model.at("parameters"));
  for (const auto& parameter : json.at("parameters")) CHECK(parameter.at("sigma") > 0);
  std::set<std::string> there, told;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path() / "out"))
    there.insert(entry.path().string());
  for (const auto& file : json.at("files")) told.insert(file.get<std::string>());
  CHECK(told == there);
}

TEST_CASE("corpus: the tolerance that is named where a procedure fails is one at which it is verified") {
  // A cube of 40 whose edges are rounded by 1.5: a box that is off by 0.4 mm along them.
  std::string points;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1, 1})
      for (int i = -9; i <= 9; ++i)
        for (int j = -9; j <= 9; ++j) {
          const double u = i == 9 || i == -9 ? i / 9.0 * 19.6 : i * 2.1,
                       v = j == 9 || j == -9 ? j / 9.0 * 19.6 : j * 2.1;
          Vec3 place, core;
          place[axis] = 20 * side, place[(axis + 1) % 3] = u, place[(axis + 2) % 3] = v;
          core = place.cwiseMax(-18.5).cwiseMin(18.5);
          const Vec3 on = core + 1.5 * (place - core).normalized();
          for (int k = 0; k < 3; ++k) points += print_number(snapped(on[k], 1e-4)) + (k < 2 ? " " : "\n");
        }
  const TemporaryDirectory folder;
  const std::string cube = (folder.path() / "cube.xyz").string();
  REQUIRE(write_file(cube, points).ok());
  const auto build = [&](const std::string& tolerance) {
    return run_partscribe({"build", cube, "--json", "--units", "mm", "--to", "openscad", "--procedure", "box",
                           "--tolerance", tolerance, "--out", (folder.path() / tolerance).string()});
  };
  const auto first = build("0.1");
  INFO(first.out << first.err);
  const auto wider = nlohmann::json::parse(first.out).at("wider");
  CHECK(wider.at("procedure") == "box");
  const double tolerance = wider.at("tolerance");
  CHECK(tolerance > 0.2);
  CHECK(tolerance < 0.8);
  CHECK(build(print_number(tolerance)).exit_code == 0);
}

TEST_CASE(
    "corpus: a build that is interrupted while it verifies leaves no file, and may be run again without --force") {
  const TemporaryDirectory folder;
  REQUIRE(write_file(folder.path() / "rod.xyz", cylinder_xyz(9, false)).ok());
  const Path out = folder.path() / "out";
  const std::string log = (folder.path() / "log").string();
  const std::vector<std::string> build = {testing::program().string(),
                                          "build",
                                          (folder.path() / "rod.xyz").string(),
                                          "--units",
                                          "mm",
                                          "--quiet",
                                          "--log",
                                          log,
                                          "--out",
                                          out.string()};
  std::vector<std::string> words = {"sh", "-c",
                                    "\"$@\" & child=$!; until grep -qs write: \"$0\" || ! kill -0 $child; do sleep "
                                    "0.01; done; kill -INT $child; wait $child",
                                    log};
  words.insert(words.end(), build.begin(), build.end());
  Context context;
  const auto output = run_process(words, {.seconds = 300}, context);
  REQUIRE(output.ok());
  INFO(output->err);
  CHECK(output->exit_code == 5);
  CHECK(output->err.find("cancelled") != std::string::npos);
  CHECK((!std::filesystem::exists(out) || std::filesystem::is_empty(out)));
  const auto again = run_process(build, {.seconds = 300}, context);
  REQUIRE(again.ok());
  CHECK(again->exit_code == 0);
  CHECK(std::filesystem::exists(out / "verdict.json"));
  CHECK_FALSE(std::filesystem::exists(out / "unfinished.json"));
  const auto third = run_process(build, {.seconds = 300}, context);
  REQUIRE(third.ok());
  CHECK(third->exit_code == 2);
}

TEST_CASE("corpus: where no procedure describes a part, the last line says so and why") {
  // A tetrahedron with a smaller one on a face: neither extruded nor turned, nor convex.
  const TemporaryDirectory folder;
  REQUIRE(
      write_file(
          folder.path() / "lump.off",
          "OFF\n5 6 0\n0 0 0\n30 0 0\n0 30 0\n0 0 30\n4 5 3\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 4\n3 2 3 4\n3 3 1 4\n")
          .ok());
  const auto output = run_partscribe({"build", (folder.path() / "lump.off").string(), "--units", "mm", "--tolerance",
                                      "0.2", "--to", "step", "--out", (folder.path() / "out").string()});
  INFO(output.out << output.err);
  CHECK(output.exit_code == 0);
  const auto at = output.out.find("No CAD procedure was found: no single extrusion or turned body describes it");
  REQUIRE(at != std::string::npos);
  CHECK(output.out.find('\n', at) + 1 == output.out.size());
}

/// A build of a simulated pin into `out` that gets `interrupts` signals as soon as its log says that it is at work.
ProcessOutput interrupted_build(const Path& folder, int interrupts) {
  simulate_part("pin", folder / "scan", 512, 0.01);
  const std::string script =
      "\"$@\" & child=$!; until [ -s \"$0\" ] || ! kill -0 $child; do sleep 0.01; done; "
      "for i in $(seq " +
      std::to_string(interrupts) + "); do kill -INT $child; sleep 0.002; done 2>/dev/null; wait $child";
  Context context;
  const std::string log = (folder / "log").string();
  const auto output =
      run_process({"sh", "-c", script, log, testing::program().string(), "build", (folder / "scan").string(), "--quiet",
                   "--log", log, "--out", (folder / "out").string()},
                  {.seconds = 300}, context);
  REQUIRE(output.ok());
  return *output;
}

TEST_CASE("corpus: Ctrl-C ends a build with 5 and one line, and leaves no result behind") {
  const TemporaryDirectory folder;
  const ProcessOutput output = interrupted_build(folder.path(), 1);
  CHECK(output.exit_code == 5);
  CHECK(output.err.find("cancelled") != std::string::npos);
  CHECK(std::count(output.err.begin(), output.err.end(), '\n') == 1);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "out/model.json"));
}

TEST_CASE("corpus: an interrupt that arrives several times at once is one interrupt") {
  const TemporaryDirectory folder;
  const ProcessOutput output = interrupted_build(folder.path(), 5);
  INFO(output.err);
  CHECK(output.exit_code == 5);
  CHECK(output.err.find("cancelled") != std::string::npos);
}

TEST_CASE("corpus: the same seed simulates the same bytes") {
  const TemporaryDirectory folder;
  simulate_part("pin", folder.path() / "one", 48, 0.02);
  simulate_part("pin", folder.path() / "two", 48, 0.02);
  for (const auto& entry : std::filesystem::directory_iterator(folder.path() / "one"))
    CHECK(bytes_of(entry.path()) == bytes_of(folder.path() / "two" / entry.path().filename()));
}

}  // namespace partscribe::testing
