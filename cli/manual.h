/// The command line as a manual page and in Markdown: what the commands declare, for those who do not run the program.
#pragma once

#include <string>
#include <vector>

#include "cli/arguments.h"

namespace partscribe::cli {

struct CommandManual {
  std::string name, summary, help;
  std::vector<Declared> own;  ///< options and operands, without those that all commands share
};

struct Manual {
  std::string version;
  std::string about, ending;  ///< what help says before and after the list of commands
  std::vector<Declared> shared;
  std::vector<CommandManual> commands;
};

/// In the language of man(7).
std::string manual_page(const Manual& manual);

/// What help says of one command, in Markdown: the second half of its page of the documentation.
std::string command_markdown(const CommandManual& command);

}  // namespace partscribe::cli
