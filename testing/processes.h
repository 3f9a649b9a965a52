/// What the system runs just now.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace partscribe::testing {

/// How many processes have the word among their arguments.
inline int processes_with(const std::string& word) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream file(entry.path() / "cmdline");
    bool found = false;
    for (std::string argument; !found && std::getline(file, argument, '\0');) found = argument == word;
    count += found;
  }
  return count;
}

}  // namespace partscribe::testing
