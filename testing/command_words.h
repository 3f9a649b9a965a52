/// The words of the command line as help lists them, for tests of what else knows them.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "testing/damage/file_damage.h"
#include "testing/program.h"

namespace partscribe::testing {

/// "build", "scan", ... in the order of help.
inline std::vector<std::string> command_words() {
  std::vector<std::string> words;
  bool listed = false;
  for (const std::string& line : lines_of(run_partscribe({"help"}).out)) {
    if (listed && line.starts_with("  ") && line[2] != ' ') words.push_back(line.substr(2, line.find(' ', 2) - 2));
    listed = (listed && !line.empty()) || line.starts_with("Subcommands:");
  }
  return words;
}

/// "--tolerance", ... : all options of a command.
inline std::set<std::string> option_words(const std::string& command) {
  std::set<std::string> words;
  for (const std::string& line : lines_of(run_partscribe({"help", command}).out)) {
    const auto name = line.find(line.starts_with("  -") ? "--" : "\n");
    if (name != std::string::npos) words.insert(line.substr(name, line.find_first_of(" ", name) - name));
  }
  return words;
}

}  // namespace partscribe::testing
