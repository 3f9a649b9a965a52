/// A full disk is one line, and nobody's fault.
#include <algorithm>
#include <catch2/catch.hpp>

#include "core/process.h"
#include "testing/program.h"

namespace partscribe::testing {
namespace {

/// The program, where `folder` has room for `bytes`.
ProcessOutput with_little_room(const Path& folder, int bytes, std::vector<std::string> arguments,
                               const Path& temporary = "/tmp") {
  arguments.insert(arguments.begin(),
                   {"bwrap", "--dev-bind", "/", "/", "--size", std::to_string(bytes), "--tmpfs", folder.string(),
                    "--setenv", "TMPDIR", temporary.string(), testing::program().string()});
  Context context;
  auto output = run_process(arguments, {.seconds = 120}, context);
  REQUIRE(output.ok());
  return std::move(output).value();
}

bool one_line(const std::string& text) { return std::ranges::count(text, '\n') == 1; }

}  // namespace

TEST_CASE("full disk: one line says where there is no room, and no file is half there") {
  if (!no_confinement().empty()) {
    WARN("skipped: " << no_confinement());
    return;
  }
  const TemporaryDirectory folder;
  const Path out = folder.path() / "small";
  std::filesystem::create_directory(out);
  const std::string model = source_file("tests/golden/bracket/model.json").string();
  const auto output =
      with_little_room(out, 4096, {"emit", model, "--to", "step", "--quiet", "--out", (out / "o").string()});
  INFO(output.out << output.err);
  CHECK(output.exit_code == 5);
  CHECK(one_line(output.err));
  CHECK(output.err.find("No space left on device") != std::string::npos);
}

TEST_CASE("full disk: a temporary folder without room is no verdict on the part") {
  if (!no_confinement().empty() || find_program("openscad").empty()) {
    WARN("skipped: " << no_confinement());
    return;
  }
  const TemporaryDirectory folder;
  const Path small = folder.path() / "small";
  std::filesystem::create_directory(small);
  const std::string part = (folder.path() / "part.scad").string(), scan = (folder.path() / "scan.xyz").string();
  REQUIRE(write_file(part, "cube([20, 15, 10]);").ok());
  std::string points;
  for (int i = 0; i <= 20; ++i)
    for (int j = 0; j <= 15; ++j)
      points +=
          std::to_string(i) + " " + std::to_string(j) + " 0\n" + std::to_string(i) + " " + std::to_string(j) + " 10\n";
  REQUIRE(write_file(scan, points).ok());
  const auto output =
      with_little_room(small, 8192, {"verify", part, scan, "--units", "mm", "--tolerance", "0.1"}, small);
  INFO(output.out << output.err);
  CHECK(output.exit_code == 4);  // not run
  CHECK(output.out.find("'openscad' had no room to write in " + small.string()) != std::string::npos);
}

}  // namespace partscribe::testing
