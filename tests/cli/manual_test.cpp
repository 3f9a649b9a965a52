/// The manual page and the pages of docs/commands hold what help says, and man(1) has no complaint.
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

TEST_CASE("manual: of each command Markdown has every option of its own, and a page of docs that its text can end") {
  const auto overview = bytes_of(source_file("docs/cli.md"));
  std::set<std::string> pages;
  for (const auto& entry : std::filesystem::directory_iterator(source_file("docs/commands")))
    pages.insert(entry.path().stem().string());
  for (const auto& command : command_words()) {
    INFO(command);
    CHECK(pages.erase(command) == 1);
    CHECK(overview.find("](commands/" + command + ".md)") != std::string::npos);
    const auto text = run_partscribe({"help", "--markdown", command}).out;
    CHECK(text.starts_with("```\npartscribe " + command + " [options]"));
    for (const auto& option : option_words(command)) {
      INFO(option);
      CHECK((text.find("| `" + option) != std::string::npos || overview.find("| `" + option) != std::string::npos));
    }
  }
  CHECK(pages.empty());
}

TEST_CASE("manual: Markdown is asked for by the name of a command") {
  const auto output = run_partscribe({"help", "--markdown", "biuld"});
  CHECK(output.exit_code == 2);
  CHECK(output.err == "partscribe: help --markdown: expected a command, found 'biuld'\n");
}

TEST_CASE("manual: text that Markdown would take for its own is printed as it is") {
  const cli::CommandManual command{"do", "", "a <b> and c_d | e\n\n  do -x | y\n", {{"--x", "A|B", "x * y|z"}}};
  const auto text = cli::command_markdown(command);
  CHECK(text.find("\na \\<b> and c\\_d \\| e\n") != std::string::npos);
  CHECK(text.find("\n```\ndo -x | y\n```\n") != std::string::npos);
  CHECK(text.find("| `--x A\\|B` | x \\* y\\|z |\n") != std::string::npos);
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
