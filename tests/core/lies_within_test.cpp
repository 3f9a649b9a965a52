/// What a file may name: its company, and nothing that a path or a symbolic link leads to elsewhere.
#include "core/lies_within.h"

#include <catch2/catch.hpp>

using namespace partscribe::core;

TEST_CASE("lies within: files of the folder and below, existing or not") {
  const TemporaryDirectory outer;
  const Path folder = outer.path() / "a";
  std::filesystem::create_directories(folder / "b");
  REQUIRE(write_file(folder / "b" / "x.stl", "x").ok());
  CHECK(lies_within(folder / "b" / "x.stl", folder));
  CHECK(lies_within(folder / "b" / ".." / "y.stl", folder));
  CHECK(lies_within("CMakeLists.txt", ""));
  CHECK(lies_within(folder / "b" / "x.stl", folder / "b" / ".." / "b"));
}

TEST_CASE("lies within: not what lies beside, above or elsewhere, is hidden, or is reached by a link") {
  const TemporaryDirectory outer;
  const Path folder = outer.path() / "a";
  std::filesystem::create_directories(folder / ".ssh");
  std::filesystem::create_directories(outer.path() / "ab");
  REQUIRE(write_file(outer.path() / "ab" / "x.stl", "x").ok());
  std::filesystem::create_symlink(outer.path() / "ab" / "x.stl", folder / "link.stl");
  std::filesystem::create_directory_symlink(outer.path() / "ab", folder / "linked");
  for (const char* name : {"../ab/x.stl", "..", ".", "", "link.stl", "linked/x.stl", "linked/../../ab/x.stl", ".ssh",
                           ".ssh/key", ".hidden.stl", "/etc/passwd", "/"})
    CHECK_FALSE(lies_within(folder / name, folder));
  CHECK_FALSE(lies_within(folder / "x.stl", outer.path() / "missing"));
}
