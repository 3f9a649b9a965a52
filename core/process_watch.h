/// A program whose output folders are watched while it runs.
#pragma once

#include <string>
#include <vector>

#include "core/process.h"

namespace partscribe::core {

struct ProcessWatch {
  std::string name;           ///< what errors call the program
  Path working_directory;     ///< may be empty
  std::vector<Path> folders;  ///< whose files count
  LineListener listener;      ///< may be empty
};

/// As run_process. The program is also ended, with an error of the kind `stopped`, once the files in the folders take
/// more than limits.file_mb together or are more than anybody needs; and, where this program runs as root, whom the
/// system grants any number, once it has more processes than limits.processes.
Result<ProcessOutput> run_watched(const std::vector<std::string>& arguments, const ProcessLimits& limits,
                                  const ProcessWatch& watch, Context& context);

}  // namespace partscribe::core
