/// What an unfinished run leaves may be replaced by the same command, and by nothing else.
#include "cli/result_folder.h"

#include <catch2/catch.hpp>

#include "testing/program.h"

namespace partscribe::testing {

using namespace cli;

namespace {

const std::vector<std::string> names = {"model.json", "part.step", "verdict.json"};

/// A run that wrote two of its files and was stopped.
Result<int> stopped_run(const Path& folder, const std::string& input) {
  ResultFolder results(folder, names, "build", {input});
  REQUIRE(results.check(true).ok());
  REQUIRE(results.begin().ok());
  for (const char* file : {"model.json", "part.step"})
    REQUIRE(write_file(folder / file, std::string("of ") + input).ok());
  return results.close(Error{"cancelled", ErrorKind::stopped});
}

bool may_write(const Path& folder, const std::string& command, const std::string& input) {
  return ResultFolder(folder, names, command, {input}).check(false).ok();
}

}  // namespace

TEST_CASE("result folder: a stopped run says what it leaves, and the next run of it replaces that") {
  const TemporaryDirectory folder;
  const auto outcome = stopped_run(folder.path(), "a.ply");
  REQUIRE_FALSE(outcome.ok());
  CHECK(outcome.error().kind == ErrorKind::stopped);
  CHECK(outcome.error().message.starts_with("cancelled; what is in " + folder.path().string() +
                                            " (model.json part.step) is unfinished"));

  CHECK(may_write(folder.path(), "build", "a.ply"));
  CHECK_FALSE(may_write(folder.path(), "build", "b.ply"));
  CHECK_FALSE(may_write(folder.path(), "fit", "a.ply"));

  ResultFolder again(folder.path(), names, "build", {"a.ply"});
  REQUIRE(again.begin().ok());
  CHECK_FALSE(std::filesystem::exists(folder.path() / "part.step"));
  REQUIRE(write_file(folder.path() / "model.json", "whole").ok());
  CHECK(again.close(0).ok());
  CHECK_FALSE(std::filesystem::exists(folder.path() / "unfinished.json"));
  CHECK_FALSE(may_write(folder.path(), "build", "a.ply"));  // finished results are somebody's
}

TEST_CASE("result folder: one that was made for nothing is gone, one that was there stays") {
  const TemporaryDirectory folder;
  const Error refusal{"three points are no part", ErrorKind::bad_input};
  for (const bool was_there : {false, true}) {
    const Path results = folder.path() / (was_there ? "old" : "new");
    if (was_there) std::filesystem::create_directory(results);
    const ResultFolder run(results, names, "build", {"a.ply"});
    std::filesystem::create_directories(results);
    CHECK_FALSE(run.close(refusal).ok());
    CHECK(std::filesystem::exists(results) == was_there);
  }
}

TEST_CASE("result folder: a mark that nobody wrote is none") {
  const TemporaryDirectory folder;
  const std::string deep = std::string(1'000'000, '[') + std::string(1'000'000, ']');
  for (const std::string text : {std::string(), std::string("{"), "{\"command\": " + deep + "}"}) {
    REQUIRE(write_file(folder.path() / "unfinished.json", text).ok());
    CHECK(may_write(folder.path(), "build", "a.ply"));
  }
}

TEST_CASE("result folder: what was changed after a stopped run is somebody's") {
  const TemporaryDirectory folder;
  REQUIRE_FALSE(stopped_run(folder.path(), "a.ply").ok());
  REQUIRE(write_file(folder.path() / "part.step", "edited by hand").ok());
  CHECK_FALSE(may_write(folder.path(), "build", "a.ply"));
  REQUIRE(write_file(folder.path() / "part.step", "of a.ply").ok());
  CHECK(may_write(folder.path(), "build", "a.ply"));
  REQUIRE(write_file(folder.path() / "verdict.json", "of another program").ok());
  CHECK_FALSE(may_write(folder.path(), "build", "a.ply"));
}

TEST_CASE(
    "result folder: an old verdict does not stay beside new files, and a run that fails before it writes changes "
    "nothing") {
  const TemporaryDirectory folder;
  REQUIRE(write_file(folder.path() / "verdict.json", "old").ok());
  ResultFolder results(folder.path(), names, "build", {"a.ply"});
  CHECK_FALSE(results.close(Error{"no points", ErrorKind::bad_input}).ok());
  CHECK(bytes_of(folder.path() / "verdict.json") == "old");
  REQUIRE(results.begin().ok());
  CHECK_FALSE(std::filesystem::exists(folder.path() / "verdict.json"));
}

}  // namespace partscribe::testing
