/// What a tool's schema allows is what the command line takes, and nothing outside the root.
#include "cli/mcp/tool_schema.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "testing/places.h"

namespace partscribe::testing {
namespace {

using namespace cli;
using Json = nlohmann::ordered_json;

std::vector<Declared> some_arguments() {
  using Takes = Declared::Takes;
  return {{"files", "", "what to read", Takes::file, {}, true},
          {"--strict", "", "no mercy", Takes::nothing},
          {"--rule", "local|max", "which rule", Takes::word, {"local", "max"}},
          {"--time-limit", "SECONDS", "for each", Takes::number, {}, false, 1, 100},
          {"--to", "LIST", "formats", Takes::list},
          {"--out", "DIR", "folder", Takes::folder}};
}

std::string words(const Json& arguments, const Path& root) {
  const auto result = command_words(arguments, some_arguments(), root);
  if (!result.ok()) return "error: " + result.error().message;
  std::string text;
  for (const auto& word : *result) text += (text.empty() ? "" : " ") + word;
  return text;
}

}  // namespace

TEST_CASE("tool schema: each option is a property of its type, and operands are required") {
  const Json schema = input_schema(some_arguments());
  CHECK(schema["required"] == Json::array({"files"}));
  CHECK(schema["additionalProperties"] == false);
  const Json& p = schema["properties"];
  CHECK(p["files"]["type"] == "array");
  CHECK(p["strict"]["type"] == "boolean");
  CHECK(p["rule"]["enum"] == Json::array({"local", "max"}));
  CHECK(p["time_limit"]["minimum"] == 1);
  CHECK(p["time_limit"]["maximum"] == 100);
  CHECK(p["to"]["items"]["type"] == "string");
  CHECK(p["out"]["description"] == "folder");
}

TEST_CASE("tool schema: a call is the command line that says the same") {
  const TemporaryDirectory folder;
  const Path root = std::filesystem::canonical(folder.path());
  CHECK(words({{"files", {"a.scad", "b/../b.ply"}}, {"strict", true}, {"rule", "max"}, {"time_limit", 2.5}}, root) ==
        "--strict --rule=max --time-limit=2.5 -- a.scad b.ply");
  CHECK(words({{"files", "a.ply"}, {"strict", false}, {"to", {"step", "iges"}}, {"out", (root / "x").string()}},
              root) == "--to=step,iges --out=x -- a.ply");
  CHECK(words({{"files", {"-rf"}}, {"rule", nullptr}}, root) == "-- -rf");
}

TEST_CASE("tool schema: what the schema does not allow is refused in a line that names it") {
  const TemporaryDirectory folder;
  const Path root = std::filesystem::canonical(folder.path());
  CHECK(words(Json::object(), root) == "error: expected the argument 'files', found none");
  CHECK(words({{"files", Json::array()}}, root) == "error: expected the argument 'files', found none");
  CHECK(words({{"files", {"a"}}, {"rulle", "max"}}, root)
            .starts_with("error: there is no argument 'rulle'; did you mean"));
  CHECK(words({{"files", {"a"}}, {"strict", "yes"}}, root) == "error: strict: expected true or false, found \"yes\"");
  CHECK(words({{"files", {1, Json::object()}}}, root).starts_with("error: files: expected"));
  CHECK(words(7, root).starts_with("error: expected arguments as a JSON object"));
}

TEST_CASE("tool schema: a complaint that speaks of options speaks of arguments to an agent") {
  CHECK(in_properties("x exists: give --strict, or --out for another; --to-day --time-limit", some_arguments()) ==
        "x exists: give \"strict\": true, or \"out\" for another; --to-day \"time_limit\"");
}

TEST_CASE("tool schema: no path leads out of the root, by links neither") {
  const TemporaryDirectory folder;
  std::filesystem::create_directories(folder.path() / "root/inner");
  std::filesystem::create_symlink("/etc", folder.path() / "root/etc");
  std::filesystem::create_symlink("inner", folder.path() / "root/link");
  const Path root = std::filesystem::canonical(folder.path() / "root");
  for (const std::string out : {"..", "../root2/a", "/etc/passwd", "etc/passwd", "inner/../../a", "", "link/../../a"}) {
    INFO(out);
    CHECK(words({{"files", {out}}}, root).find("expected a path within") != std::string::npos);
    CHECK(words({{"files", {"a"}}, {"out", out}}, root).find("expected a path within") != std::string::npos);
  }
  CHECK(words({{"files", {std::string("a\0b", 3)}}}, root).find("expected a path within") != std::string::npos);
  CHECK(words({{"files", {"link/a"}}}, root) == "-- inner/a");
}

TEST_CASE("tool schema: every argument of every command has a name of its own and a help") {
  for (const auto& command :
       {build_command(), verify_command(), explain_command(), measure_command(), render_command()}) {
    auto declared = declared_by(command);
    for (const auto& shared : shared_options()) declared.push_back(shared);
    const Json schema = input_schema(declared);
    CHECK(schema["properties"].size() == declared.size());
    for (const auto& [name, property] : schema["properties"].items()) {
      INFO(command.name + " " + name);
      CHECK(name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == std::string::npos);
      CHECK(property["description"].get<std::string>().size() > 5);
    }
  }
}

}  // namespace partscribe::testing
