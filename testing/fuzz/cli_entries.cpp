// What the program itself reads: the words of its command line, messages of agents, and its own verdict.json.
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/mcp/server.h"
#include "cli/mcp/tool_schema.h"
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

void fuzz_mcp(std::string_view bytes) {
  using Json = nlohmann::ordered_json;
  using Takes = Declared::Takes;
  const std::vector<Declared> declared = {{"files", "", "", Takes::file, {}, true},
                                          {"--tolerance", "MM", "", Takes::word},
                                          {"--rule", "", "", Takes::word, {"local", "max"}},
                                          {"--strict", "", "", Takes::nothing}};
  Service service{
      "name", "Title", "1", "", Json::array({{{"name", "verify"}, {"inputSchema", input_schema(declared)}}}).dump(),
      {}};
  service.call = [&](const std::string&, const std::string& arguments, Context&) {
    const auto words = command_words(Json::parse(arguments), declared, "/usr/share");
    return Json{{"content", Json::array()}, {"isError", !words.ok()}}.dump();
  };
  const auto check = [](const std::string& line) {
    ensure(line.find('\n') == std::string::npos, "an answer is one line");
    ensure(Json::accept(line), "an answer is JSON");
  };
  Server server(service, check);
  while (!bytes.empty()) {
    const auto end = std::min(bytes.find('\n'), bytes.size());
    server.receive(std::string(bytes.substr(0, end)));
    bytes.remove_prefix(std::min(end + 1, bytes.size()));
  }
  server.finish();
}

}  // namespace partscribe::testing
