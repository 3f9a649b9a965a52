/// Every command of the program: one entry each, run by main.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "cli/session.h"
#include "core/result.h"

namespace partscribe::cli {

/// A word after `partscribe`, its help and what it does.
struct Command {
  std::string name;
  std::string summary;                       ///< one line for the list of commands
  std::string help;                          ///< examples first, then what it reads and writes
  std::function<void(Arguments&)> declare;   ///< its own options; the shared ones are added to all
  std::function<Result<int>(Session&)> run;  ///< the exit code, or one line that says why not
};

Command build_command();
Command scan_command();
Command fit_command();
Command emit_command();
Command verify_command();
Command report_command();
Command render_command();
Command explain_command();
Command measure_command();
Command analyse_command();
Command simulate_command();
Command views_command();
Command paper_command();
Command mcp_command();

/// A command's own options and operands, and those that all commands share.
std::vector<Declared> declared_by(const Command& command);
std::vector<Declared> shared_options();

/// Parses, runs one command and returns the exit code. Prints nothing but what the commands print and one line
/// `partscribe: ...` on standard error for an error.
int run_program(int argc, const char* const* argv, const std::vector<Command>& commands, const std::string& version);

}  // namespace partscribe::cli
