/// The manual page holds what help says, and man(1) has no complaint.
#include "cli/manual.h"

#include <catch2/catch.hpp>
#include <sstream>

#include "testing/command_words.h"
#include "testing/program.h"

namespace partscribe::testing {
namespace {

/// The part of the page from this heading to the next.
std::string section(const std::string& page, const std::string& heading) {
  const auto begin = page.find("\n.SH " + heading + "\n");
  REQUIRE(begin != std::string::npos);
  return page.substr(begin, page.find("\n.SH ", begin + 1) - begin);
}

std::string as_option(const std::string& name) {
  std::string result;
  for (const char c : name) result += c == '-' ? "\\-" : std::string(1, c);
  return "\\fB" + result + "\\fR";
}

}  // namespace

TEST_CASE("manual: every command and every option that help names is in the page, where it belongs") {
  const auto page = run_partscribe({"help", "--man"}).out;
  const auto shared = section(page, "OPTIONS OF EVERY COMMAND");
  std::size_t options = 0;
  for (const auto& command : command_words()) {
    INFO(command);
    const auto own = section(page, "\"PARTSCRIBE " + command + "\"");
    for (const auto& option : option_words(command)) {
      INFO(option);
      ++options;
      CHECK((own.find("\n" + as_option(option)) == std::string::npos) ==
            (shared.find(as_option(option)) != std::string::npos));
    }
  }
  CHECK(options > 100);
}

TEST_CASE("manual: says the version, the exit codes and the examples, and is shown without a warning") {
  const TemporaryDirectory folder;
  const auto page = run_partscribe({"help", "--man"}).out;
  const auto version = run_partscribe({"--version"}).out;
  CHECK(page.find(".TH PARTSCRIBE 1 \"\" \"" + version.substr(0, version.find('\n')) + "\"") != std::string::npos);
  REQUIRE(write_file(folder.path() / "partscribe.1", page).ok());
  if (find_program("man").empty()) {
    WARN("skipped: man is not installed");
    return;
  }
  Context context;
  const auto shown = run_process(
      {"env", "MANWIDTH=120", "LC_ALL=C.UTF-8", "man", "--warnings", "-l", (folder.path() / "partscribe.1").string()},
      {.seconds = 30}, context);
  REQUIRE(shown.ok());
  CHECK(shown->exit_code == 0);
  CHECK(shown->err.empty());
  for (const char* text : {"--tolerance MM", "6 the scan cannot decide", "  partscribe build bracket.ply "}) {
    INFO(text);
    CHECK(shown->out.find(text) != std::string::npos);
  }
}

TEST_CASE("manual: text that man(7) would take for its own is printed as it is") {
  const cli::Manual manual{"1", "Partscribe does.\n\n.start\\n-x\n  'quoted\n", "", {}, {}};
  const auto page = cli::manual_page(manual);
  CHECK(page.find("\n\\&.start\\en\\-x\n") != std::string::npos);
  CHECK(page.find(".nf\n\\&'quoted\n.fi") != std::string::npos);
}

}  // namespace partscribe::testing
