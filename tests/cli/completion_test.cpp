/// Completion knows the commands, options and values that the program accepts, and no others.
#include "cli/completion.h"

#include <catch2/catch.hpp>
#include <regex>

#include "testing/command_words.h"
#include "testing/damage/file_damage.h"
#include "testing/program.h"

namespace partscribe::testing {
namespace {

std::string script_for(const std::string& shell) {
  const auto output = run_partscribe({"help", "--completion", shell});
  REQUIRE(output.exit_code == 0);
  return output.out;
}

std::string output_of(const std::vector<std::string>& arguments, const Path& folder = {}) {
  Context context;
  const auto output = run_process(arguments, {.seconds = 60}, context, folder);
  REQUIRE(output.ok());
  INFO(output->err);
  CHECK(output->err.empty());
  CHECK(output->exit_code == 0);
  return output->out;
}

/// What bash offers for the last of these words.
std::set<std::string> completed_by_bash(const std::vector<std::string>& words, const Path& folder = {}) {
  std::string text = "compopt() { :; }\n" + script_for("bash") + "COMP_WORDS=(partscribe";
  for (const auto& word : words) text += " '" + word + "'";
  text += ")\nCOMP_CWORD=" + std::to_string(words.size()) +
          "\n_partscribe\nif ((${#COMPREPLY[@]})); then printf '%s\\n' \"${COMPREPLY[@]}\"; fi\n";
  const auto lines = lines_of(output_of({"bash", "-c", text}, folder));
  return {lines.begin(), lines.end()};
}

}  // namespace

TEST_CASE("completion: bash offers every command, and of each the options that help names") {
  auto commands = command_words();
  commands.insert(commands.end(), {"help", "--help", "--version"});
  CHECK(completed_by_bash({""}) == std::set<std::string>(commands.begin(), commands.end()));
  for (const auto& command : command_words()) {
    INFO(command);
    CHECK(completed_by_bash({command, "--"}) == option_words(command));
  }
}

TEST_CASE("completion: bash offers values where an option takes some, files and folders where it takes those") {
  using Words = std::set<std::string>;
  CHECK(completed_by_bash({"build", "--units", ""}) == Words{"mm", "cm", "m", "inch"});
  CHECK(completed_by_bash({"build", "--units", "=", "i"}) == Words{"inch"});
  CHECK(completed_by_bash({"build", "--units", "="}) == Words{"mm", "cm", "m", "inch"});
  CHECK(completed_by_bash({"fit", "--procedure", "ext"}) == Words{"extrude"});
  CHECK(completed_by_bash({"build", "--tolerance", ""}).empty());
  CHECK(completed_by_bash({"explain", "--procedure", "ext"}).empty());
  CHECK(completed_by_bash({"help", "mea"}) == Words{"measure"});
  CHECK(completed_by_bash({"help", "--completion", ""}) == Words{"bash", "zsh", "fish"});
  const TemporaryDirectory folder;
  std::filesystem::create_directory(folder.path() / "parts");
  REQUIRE(write_file(folder.path() / "part one.ply", "").ok());
  CHECK(completed_by_bash({"build", "p"}, folder.path()) == Words{"parts", "part one.ply"});
  CHECK(completed_by_bash({"build", "--out", "p"}, folder.path()) == Words{"parts"});
  CHECK(completed_by_bash({"build", "--force", "part "}, folder.path()) == Words{"part one.ply"});
}

TEST_CASE("completion: zsh and fish know the same options, and accept their scripts") {
  const auto zsh = script_for("zsh"), fish = script_for("fish");
  const auto names_in = [](const std::string& text, const std::regex& pattern) {
    std::set<std::string> names;
    for (auto found = std::sregex_iterator(text.begin(), text.end(), pattern); found != std::sregex_iterator(); ++found)
      names.insert("--" + (*found)[1].str());
    return names;
  };
  const std::regex zsh_option(R"(\n *'--([a-z-]+)\[)");
  const auto part = [](const std::string& text, const std::string& begin, const std::string& end) {
    const auto from = text.find(begin);
    REQUIRE(from != std::string::npos);
    return text.substr(from, text.find(end, from) - from);
  };
  const auto shared = names_in(part(zsh, "local -a shared=(", "\n  )"), zsh_option);
  for (const auto& command : command_words()) {
    INFO(command);
    const auto all = option_words(command);
    auto known = names_in(part(zsh, "\n    " + command + ")\n", "\n      ) ;;"), zsh_option);
    known.insert(shared.begin(), shared.end());
    CHECK(known == all);
    known = names_in(fish, std::regex("seen_subcommand_from " + command + "' -l ([a-z-]+)"));
    const auto everywhere = names_in(fish, std::regex("seen_subcommand_from build [a-z ]+' -l ([a-z-]+)"));
    known.insert(everywhere.begin(), everywhere.end());
    known.insert("--help");
    CHECK(known == all);
  }
  const TemporaryDirectory folder;
  for (const auto& [shell, text] : {std::pair(std::string("zsh"), zsh), std::pair(std::string("fish"), fish)}) {
    if (find_program(shell).empty()) continue;
    REQUIRE(write_file(folder.path() / shell, text).ok());
    CHECK(output_of({shell, "-n", (folder.path() / shell).string()}).empty());
  }
}

TEST_CASE("completion: another shell is refused with the names of those that are known") {
  const auto output = run_partscribe({"help", "--completion", "fis"});
  CHECK(output.exit_code == 2);
  CHECK(output.err.find("expected one of bash, zsh, fish, found 'fis'; did you mean fish?") != std::string::npos);
  CHECK(run_partscribe({"help", "--completion"}).exit_code == 2);
}

}  // namespace partscribe::testing
