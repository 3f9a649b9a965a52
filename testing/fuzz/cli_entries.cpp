// What the program itself reads: the words of its command line, and its own verdict.json.
#include "cli/commands.h"
#include "cli/verdict_file.h"
#include "core/ensure.h"
#include "testing/fuzz/entries.h"

namespace partscribe::testing {

using namespace cli;

void fuzz_verdict(std::string_view bytes) {
  const auto verdict = read_verdict_json(std::string(bytes), "verdict.json");
  if (!verdict.ok()) return;
  const std::string text = write_verdict_json(*verdict);
  const auto again = read_verdict_json(text, "verdict.json");
  ensure(again.ok() && write_verdict_json(*again) == text, "a verdict survives writing and reading");
}

void fuzz_words(std::string_view bytes) {
  std::vector<Command> commands = {build_command(),   scan_command(),    verify_command(),
                                   analyse_command(), measure_command(), simulate_command()};
  for (auto& command : commands) command.run = [](Session&) { return Result<int>(0); };
  std::vector<std::string> words = {"partscribe"};
  while (!bytes.empty()) {
    const auto end = std::min(bytes.find('\n'), bytes.size());
    words.emplace_back(bytes.substr(0, std::min(end, bytes.find('\0'))));
    bytes.remove_prefix(std::min(end + 1, bytes.size()));
    // One opens a file, the other starts a program.
    if (words.back().find("log") != std::string::npos || words.back().find("version") != std::string::npos) return;
  }
  std::vector<const char*> pointers;
  for (const auto& word : words) pointers.push_back(word.c_str());
  pointers.push_back(nullptr);
  const int code = run_program(static_cast<int>(words.size()), pointers.data(), commands, "0");
  ensure(code == 0 || code == 2, "words are understood, or refused as bad usage");
}

}  // namespace partscribe::testing
