/// Exit codes and messages: what a script around the program relies on.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/process.h"
#include "core/random.h"
#include "geometry/vec.h"
#include "testing/program.h"

namespace partscribe::testing {

using namespace geometry;

namespace {

/// One line that begins as every error does.
void check_one_line(const std::string& err) {
  INFO(err);
  CHECK(err.starts_with("partscribe: "));
  CHECK(std::count(err.begin(), err.end(), '\n') == 1);
}

std::string tetrahedron_off() {
  return "OFF\n4 4 0\n0 0 0\n10 0 0\n0 10 0\n0 0 10\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
}

}  // namespace

TEST_CASE("command line: help and version succeed and speak to standard output") {
  const auto version = run_partscribe({"--version"});
  CHECK(version.exit_code == 0);
  CHECK(version.out.starts_with("partscribe 0."));
  const auto help = run_partscribe({"--help"});
  CHECK(help.exit_code == 0);
  for (const char* command :
       {"build", "scan", "fit", "emit", "verify", "report", "explain", "measure", "analyse", "simulate", "views"}) {
    CHECK(help.out.find(std::string("  ") + command) != std::string::npos);
    const auto own = run_partscribe({command, "--help"});
    CHECK(own.exit_code == 0);
    CHECK(own.out.find("Examples") != std::string::npos);
    CHECK(own.out.find("--tolerance") != std::string::npos);
    CHECK(own.err.empty());
  }
}

TEST_CASE("command line: the version names the CAD programs that will be used, and one that is missing") {
  Context context;
  const auto version = run_partscribe({"--version"}).out;
  CHECK(version.find("\nOpenCASCADE 7.") != std::string::npos);
  const auto bare =
      run_process({"/usr/bin/env", "PATH=/nowhere", program().string(), "--version"}, {.seconds = 30}, context);
  REQUIRE(bare.ok());
  CHECK(bare->exit_code == 0);
  CHECK(bare->out.find("\nOpenSCAD is missing: no script can be verified\n") != std::string::npos);
  const Path openscad = find_program("openscad");
  if (!openscad.empty()) CHECK(version.find(", " + openscad.string() + "\n") != std::string::npos);
}

TEST_CASE("command line: bad usage ends with 2 and one line that says what to do next") {
  const std::vector<std::vector<std::string>> bad = {
      {"buidl", "x.ply"},
      {"build"},
      {"build", "x.ply", "--tolerance", "-1"},
      {"build", "x.ply", "--tolerance", "0,1"},
      {"build", "x.ply", "--units", "parsec"},
      {"build", "x.ply", "--to", "catia"},
      {"build", "x.ply", "--no-such-option"},
      {"verify", "part.scad"},
      {"simulate", "x.stl", "--views", "many"},
      {"views", "--plan", "many"},
      {"simulate", "x.stl", "--sigma", "1", "--sigma-codes", "2"},
  };
  for (const auto& arguments : bad) {
    const auto output = run_partscribe(arguments);
    INFO(arguments.back());
    CHECK(output.exit_code == 2);
    CHECK(output.out.empty());
    check_one_line(output.err);
  }
}

TEST_CASE("command line: a misspelt command, option or name gets a suggestion") {
  const std::vector<std::pair<std::vector<std::string>, std::string>> misspelt = {
      {{"buidl", "x.ply"}, "did you mean build?"},
      {{"build", "x.ply", "--tolerence", "0.1"}, "there is no option --tolerence; did you mean --tolerance?"},
      {{"build", "x.ply", "--tolerence=0.1"}, "there is no option --tolerence; did you mean --tolerance?"},
      {{"build", "x.ply", "-tolerance", "0.1"}, "did you mean --tolerance?"},
      {{"build", "--tol", "0.1", "x.ply"}, "did you mean --tolerance?"},
      {{"build", "x.ply", "--procedure", "cilinder"}, "did you mean cylinder?"},
      {{"build", "x.ply", "--units", "inches"}, "did you mean inch?"},
      {{"help", "verfiy"}, "did you mean verify?"},
  };
  for (const auto& [arguments, suggestion] : misspelt) {
    const auto output = run_partscribe(arguments);
    INFO(output.err);
    CHECK(output.exit_code == 2);
    CHECK(output.err.find(suggestion) != std::string::npos);
    check_one_line(output.err);
  }
  CHECK(run_partscribe({"build", "x.ply", "--catia"}).err.find("did you mean") == std::string::npos);
}

TEST_CASE("command line: an unknown procedure is refused before anything is read, with the names of those that exist") {
  for (const char* command : {"build", "fit"}) {
    const auto output = run_partscribe({command, "missing.ply", "--procedure", "foo"});
    INFO(output.err);
    CHECK(output.exit_code == 2);
    for (const char* name : {"'foo'", "sphere", "cylinder", "revolve", "extrude", "triangulation"})
      CHECK(output.err.find(name) != std::string::npos);
    // What explain calls a rival may be asked for as well.
    for (const char* name : {"extrude", "surface of revolution", "triangulation"})
      CHECK(run_partscribe({command, "missing.ply", "--procedure", name}).exit_code == 3);
  }
}

TEST_CASE("command line: numbers with a decimal comma or a unit are refused with the number to write") {
  const std::vector<std::pair<std::string, std::string>> numbers = {
      {"0,1", "write 0.1"}, {"0.1mm", "write 0.1"}, {"0,1 mm", "write 0.1"}};
  for (const auto& [given, advice] : numbers) {
    const auto output = run_partscribe({"build", "x.ply", "--tolerance", given});
    INFO(output.err);
    CHECK(output.exit_code == 2);
    CHECK(output.err.find(advice) != std::string::npos);
  }
  for (const char* other : {"fine", "1cm", "1x"})
    CHECK(run_partscribe({"build", "x.ply", "--tolerance", other}).err.find("write") == std::string::npos);
}

TEST_CASE("command line: help explains the program and each command") {
  CHECK(run_partscribe({"help"}).out == run_partscribe({"--help"}).out);
  const auto build = run_partscribe({"help", "build"});
  CHECK(build.exit_code == 0);
  CHECK(build.out == run_partscribe({"build", "--help"}).out);
}

TEST_CASE("command line: a file whose name begins with a dash is read by its path or after --") {
  const TemporaryDirectory folder;
  REQUIRE(write_file(folder.path() / "-dash.off", tetrahedron_off()).ok());
  const auto hint = run_partscribe({"scan", "-dash.off"}, folder.path());
  CHECK(hint.exit_code == 2);
  CHECK(hint.err.find("write ./-dash.off") != std::string::npos);
  check_one_line(hint.err);
  CHECK(run_partscribe({"scan", "./-dash.off", "--units", "mm", "--quiet"}, folder.path()).exit_code == 0);
  CHECK(std::filesystem::is_regular_file(folder.path() / "dash-partscribe/cloud.ply"));
  CHECK(run_partscribe({"scan", "--units", "mm", "--quiet", "--out", "out", "--", "-dash.off"}, folder.path())
            .exit_code == 0);
}

TEST_CASE("command line: --force replaces no other part's results in a folder that only a name led to") {
  const TemporaryDirectory folder;
  const auto cwd = folder.path();
  for (const char* file : {"a b.off", "a_b.off"}) REQUIRE(write_file(cwd / file, tetrahedron_off()).ok());
  REQUIRE(
      run_partscribe({"fit", "a b.off", "--units", "mm", "--quiet", "--procedure", "triangulation"}, cwd).exit_code ==
      0);
  const auto refused = run_partscribe({"fit", "a_b.off", "--force", "--quiet"}, cwd);
  CHECK(refused.exit_code == 2);
  CHECK(refused.err.find("a b.off") != std::string::npos);
  check_one_line(refused.err);
  CHECK(run_partscribe({"fit", "a b.off", "--units", "mm", "--force", "--quiet", "--procedure", "triangulation"}, cwd)
            .exit_code == 0);
  CHECK(run_partscribe({"fit", "a_b.off", "--units", "mm", "--force", "--quiet", "--procedure", "triangulation",
                        "--out", "a_b-partscribe"},
                       cwd)
            .exit_code == 0);
}

TEST_CASE("command line: emitting takes the verdict on the old files away") {
  const TemporaryDirectory folder;
  const std::string model = source_file("corpus/pin/model.json").string(), out = folder.path().string();
  REQUIRE(write_file(folder.path() / "verdict.json", "old").ok());
  CHECK(run_partscribe({"emit", model, "--to", "openscad", "--out", out}).exit_code == 2);
  CHECK(run_partscribe({"emit", model, "--to", "openscad", "--out", out, "--force"}).exit_code == 0);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "verdict.json"));
}

TEST_CASE("command line: that a file is judged by itself is remarked on") {
  const TemporaryDirectory folder;
  const auto file = [&](const std::string& name, const std::string& bytes) {
    REQUIRE(write_file(folder.path() / name, bytes).ok());
    return (folder.path() / name).string();
  };
  const std::string one = file("one.off", tetrahedron_off()), copy = file("copy.off", tetrahedron_off()),
                    other = file("other.off", tetrahedron_off() + "# other\n");
  const auto remarks = [&](const std::string& artifact, const std::string& scan) {
    const auto output = run_partscribe({"verify", artifact, scan, "--units", "mm", "--tolerance", "0.1", "--quiet"});
    INFO(output.err);
    return std::pair(output.exit_code, output.err.find("agrees with itself") != std::string::npos);
  };
  CHECK(remarks(one, one) == std::pair(0, true));
  CHECK(remarks(one, copy) == std::pair(0, true));
  CHECK(remarks(one, other) == std::pair(0, false));
}

TEST_CASE("command line: hostile inputs end with 3 and one line") {
  const TemporaryDirectory folder;
  const auto file = [&](const std::string& name, const std::string& bytes) {
    REQUIRE(write_file(folder.path() / name, bytes).ok());
    return (folder.path() / name).string();
  };
  const std::vector<std::string> bad = {
      (folder.path() / "missing.ply").string(),
      folder.path().string(),
      file("bad_empty.ply", ""),
      file("bad_header.ply", "ply\nformat ascii 1.0\nelement vertex 99999999999999\nproperty float x\nend_header\n"),
      file("bad_noise.stl", std::string(2000, '\xff')),
      file("bad_text.xyz", "these are\nno numbers\n"),
      file("bad_nan.xyz", "nan nan nan\ninf 0 0\n"),
      file("bad_index.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"),
      file("bad.json", "{\"views\": [{\"file\": \"../../../../etc/passwd\"}]}"),
  };
  for (const auto& input : bad) {
    const auto output = run_partscribe({"build", input, "--out", (folder.path() / "out").string(), "--quiet"});
    INFO(input);
    CHECK(output.exit_code == 3);
    CHECK(output.out.empty());
    check_one_line(output.err);
  }
  const auto model = run_partscribe({"explain", file("model.json", "{}")});
  CHECK(model.exit_code == 3);
  check_one_line(model.err);
  const TemporaryDirectory empty;
  for (const char* command : {"explain", "report"}) {
    const auto none = run_partscribe({command, empty.path().string(), "--quiet"});
    CHECK(none.exit_code == 3);
    check_one_line(none.err);
    CHECK(none.err.find("expected a folder that build or fit has filled") != std::string::npos);
  }
}

TEST_CASE("command line: nothing is overwritten without --force") {
  const TemporaryDirectory folder;
  const std::string model = source_file("corpus/pin/model.json").string(), out = folder.path().string();
  REQUIRE(run_partscribe({"emit", model, "--to", "openscad", "--out", out}).exit_code == 0);
  const std::string first = bytes_of(folder.path() / "part.scad");
  REQUIRE(write_file(folder.path() / "part.scad", "edited by hand").ok());

  const auto refused = run_partscribe({"emit", model, "--to", "openscad", "--out", out});
  CHECK(refused.exit_code == 2);
  check_one_line(refused.err);
  CHECK(refused.err.find("--force") != std::string::npos);
  CHECK(bytes_of(folder.path() / "part.scad") == "edited by hand");
  // Also when only another file of the same set would be written: a folder's files belong together.
  CHECK(run_partscribe({"emit", model, "--to", "step", "--out", out}).exit_code == 2);

  CHECK(run_partscribe({"emit", model, "--to", "openscad", "--out", out, "--force"}).exit_code == 0);
  CHECK(bytes_of(folder.path() / "part.scad") == first);
}

TEST_CASE("command line: what a command reads it does not write, not even with --force") {
  const TemporaryDirectory folder;
  const Path f = folder.path();
  const std::string part = tetrahedron_off(), scan = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  REQUIRE(write_file(f / "part.off", part).ok());
  REQUIRE(write_file(f / "scan.xyz", scan).ok());
  const std::vector<std::vector<std::string>> commands = {
      {"verify", "part.off", "scan.xyz", "--force", "--csv", "part.off"},
      {"verify", "part.off", "scan.xyz", "--force", "--json-file", "./scan.xyz"},
      {"measure", "part.off", "--force", "--csv", "part.off"},
      {"render", "part.off", "--log", "part.off"}};
  for (const auto& command : commands) {
    const auto output = run_partscribe(command, f);
    INFO(command.front() << " " << command.back());
    CHECK(output.exit_code == 2);
    check_one_line(output.err);
    CHECK(output.err.find("is read by this command") != std::string::npos);
  }
  CHECK(bytes_of(f / "part.off") == part);
  CHECK(bytes_of(f / "scan.xyz") == scan);
}

TEST_CASE("command line: names that lead nowhere are refused by every command in one line") {
  const TemporaryDirectory folder;
  const Path f = folder.path();
  std::filesystem::create_symlink("loop.step", f / "loop.step");
  REQUIRE(write_file(f / "scan.xyz", "0 0 0\n1 0 0\n").ok());
  for (const std::string& file : {std::string("loop.step"), std::string(300, 'a') + ".scad"})
    for (const std::string command : {"verify", "render", "report"}) {
      std::vector<std::string> words = {command, file};
      if (command != "render") words.push_back("scan.xyz");
      const auto output = run_partscribe(words, f);
      INFO(command << " " << file);
      CHECK(output.exit_code == 3);
      CHECK(output.err.find("internal error") == std::string::npos);
    }
}

TEST_CASE("command line: build refuses an occupied folder before the long work") {
  const TemporaryDirectory folder;
  REQUIRE(write_file(folder.path() / "part.off", tetrahedron_off()).ok());
  REQUIRE(write_file(folder.path() / "model.json", "mine").ok());
  const auto output = run_partscribe({"build", (folder.path() / "part.off").string(), "--out", folder.path().string()});
  CHECK(output.exit_code == 2);
  CHECK(output.err.find("model.json exists already") != std::string::npos);
  CHECK(bytes_of(folder.path() / "model.json") == "mine");
}

TEST_CASE("command line: explain speaks words, and with --json the model itself") {
  const std::string model = source_file("corpus/pin/model.json").string();
  const auto words = run_partscribe({"explain", model});
  CHECK(words.exit_code == 0);
  CHECK(words.out.find("a surface of revolution") != std::string::npos);
  CHECK(words.out.find("shank_radius = 6 mm") != std::string::npos);
  const auto json = run_partscribe({"explain", model, "--json"});
  CHECK(json.exit_code == 0);
  CHECK(json.out.front() == '{');
  CHECK(json.out.find("\"shank_radius\"") != std::string::npos);
}

TEST_CASE("command line: Ctrl-C is obeyed within a second, wherever it comes") {
  const TemporaryDirectory folder;
  std::string text;
  Random random(3);
  for (int i = 0; i < 60'000; ++i) {
    const Vec3 p(random.normal(), random.normal(), random.normal());
    text += print_number(30 * p.x() / p.norm()) + " " + print_number(20 * p.y() / p.norm()) + " " +
            print_number(10 * std::abs(p.z())) + "\n";
  }
  REQUIRE(write_file(folder.path() / "lump.xyz", text).ok());
  Context context;
  constexpr int before_it_listens = 130;  // ended by the signal itself
  for (const double moment : {0.3, 0.8, 1.5, 2.3}) {
    const auto run = run_process({"timeout", "--preserve-status", "-s", "INT", print_number(moment),
                                  testing::program().string(), "build", "lump.xyz", "--out", "o", "--force"},
                                 {.seconds = 60}, context, folder.path());
    REQUIRE(run.ok());
    INFO(moment << " s: " << run->err);
    CHECK((run->exit_code == 5 || (run->exit_code == before_it_listens && run->err.empty())));
    CHECK((run->exit_code != 5 || run->err.find("partscribe: cancelled") != std::string::npos));
    CHECK(run->seconds < moment + 2);  // the machine may have other work
  }
}

TEST_CASE("program: output that does not arrive is an error, and a reader that wants no more is none") {
  Context context;
  const auto said = [&](const std::string& line) {
    const auto run = run_process({"sh", "-c", line, program().string()}, {.seconds = 30}, context);
    REQUIRE(run.ok());
    return *run;
  };
  const auto lost = said("\"$0\" help --man > /dev/full");
  CHECK(lost.exit_code == 5);
  CHECK(lost.err.find("partscribe: standard output cannot be written") == 0);
  // A pipe that nobody reads any more, to a program that does not end by that.
  CHECK(said("trap '' PIPE; { sleep 0.2; \"$0\" help --man; echo ended with $? >&2; } | true").err == "ended with 0\n");
}

TEST_CASE("program: cancelled, it leaves no temporary folder") {
  const TemporaryDirectory folder;
  std::filesystem::create_directory(folder.path() / "tmp");
  Context context;
  const auto run = run_process({"sh", "-c", "TMPDIR=$PWD/tmp timeout -s INT 1.5 \"$0\" build \"$1\" --quiet; ls tmp",
                                program().string(), source_file("corpus/tie_bar/scan/scan.json").string()},
                               {.seconds = 60}, context, folder.path());
  REQUIRE(run.ok());
  CHECK(run->out == "");
}

TEST_CASE("program: a copy of a script, under whatever name, is judged by the model beside it") {
  const TemporaryDirectory folder;
  const Path f = folder.path();
  std::filesystem::copy_file(source_file("corpus/tie_bar/model.json"), f / "model.json");
  REQUIRE(run_partscribe({"emit", "model.json", "--to", "openscad", "--quiet"}, f).exit_code == 0);
  std::filesystem::copy_file(f / "part.scad", f / "mine.scad");
  const std::string scan = source_file("corpus/tie_bar/scan/scan.json").string();
  const auto own = run_partscribe({"verify", "part.scad", scan}, f),
             copy = run_partscribe({"verify", "mine.scad", scan}, f);
  CHECK(own.exit_code == copy.exit_code);
  CHECK(copy.out.find("as in the model beside the artifact") != std::string::npos);
  const auto rows = [](const std::string& text) { return text.substr(text.find("feature by feature"), 1500); };
  CHECK(rows(own.out).substr(0, 600) == rows(copy.out).substr(0, 600));
}

}  // namespace partscribe::testing
