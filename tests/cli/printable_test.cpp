/// What strangers wrote reaches the terminal as text and nothing else.
#include "cli/printable.h"

#include <catch2/catch.hpp>

#include "testing/program.h"

namespace partscribe::testing {

using cli::printable;

TEST_CASE("printable: control characters are shown as question marks, all other text as it is") {
  CHECK(printable("a\tb\n\xc3\x97 \xe9\x9b\xb6 \xc2\xb0") == "a\tb\n\xc3\x97 \xe9\x9b\xb6 \xc2\xb0");
  CHECK(printable("\x1b[31mred\x07\r\x7f") == "?[31mred???");
  CHECK(printable("\xc2\x9b"
                  "31m") == "??31m");
  CHECK(printable(std::string("a\0b", 3)) == "a?b");
}

TEST_CASE("printable: a file's name and words do not reach the terminal as commands") {
  const TemporaryDirectory folder;
  const Path file = folder.path() / "a\x1b[31m.ply";
  REQUIRE(write_file(file, "\x1b]0;title\x07").ok());
  const auto output = run_partscribe({"scan", file.string(), "--out", (folder.path() / "out").string()});
  CHECK(output.exit_code == 3);
  CHECK(output.err.find("a?[31m.ply") != std::string::npos);
  CHECK(output.err.find('\x1b') == std::string::npos);
}

}  // namespace partscribe::testing
