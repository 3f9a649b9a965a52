/// Which files a script names, and so may read.
#include "verify/evaluate/openscad_files.h"

#include <catch2/catch.hpp>

using namespace partscribe::verify;

namespace {

/// The names of the files of part.scad, in a folder with these files; without the script itself.
std::vector<std::string> named(const std::string& script,
                               const std::vector<std::pair<std::string, std::string>>& files) {
  const TemporaryDirectory folder;
  for (const auto& [name, text] : files) {
    std::filesystem::create_directories((folder.path() / name).parent_path());
    REQUIRE(write_file(folder.path() / name, text).ok());
  }
  const Path part = folder.path() / "part.scad";
  REQUIRE(write_file(part, script).ok());
  std::vector<std::string> names;
  for (const auto& file : files_of_script(part)) names.push_back(file.lexically_relative(folder.path()).string());
  REQUIRE(names.at(0) == "part.scad");
  names.erase(names.begin());
  return names;
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("openscad files: what is used, included or named in a string, and what that names") {
  CHECK(named("use <lib/a.scad>\nimport(\"x.stl\");", {{"lib/a.scad", "include<b.scad>\nsurface(\"y.dat\");"},
                                                       {"lib/b.scad", "import(\"x.stl\");"},
                                                       {"lib/x.stl", ""},
                                                       {"x.stl", ""},
                                                       {"y.dat", ""},
                                                       {"z.dat", ""}}) ==
        Names{"lib/a.scad", "x.stl", "lib/b.scad", "y.dat", "lib/x.stl"});
  CHECK(named("include <part.scad>\nuse <a.scad>", {{"a.scad", "use <part.scad>\nuse <a.scad>"}}) == Names{"a.scad"});
}

TEST_CASE("openscad files: remarks and quotes within strings hide no name") {
  const std::vector<std::pair<std::string, std::string>> files = {{"a.stl", ""}, {"b\"c.stl", ""}};
  CHECK(named("// 5\" pipe\nimport(\"a.stl\");", files) == Names{"a.stl"});
  CHECK(named("/* \" */ import(\"a.stl\");", files) == Names{"a.stl"});
  CHECK(named("x = \"// no remark\"; import(\"a.stl\");", files) == Names{"a.stl"});
  CHECK(named("import(\"b\\\"c.stl\");", files) == Names{"b\"c.stl"});
}

TEST_CASE("openscad files: a text that ends too early, and one without end, come to an end") {
  for (const char* script : {"", "/", "/*", "/* *", "//", "\"", "\"a\\", "use", "use <", "use <a.scad", "include\n<"})
    CHECK(named(script, {{"a.stl", ""}}).empty());
  std::string many;
  for (int i = 0; i < 300'000; ++i) many += "\"x\"";
  CHECK(named(many, {{"a.stl", ""}}).empty());
}
