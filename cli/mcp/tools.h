/// The commands that an agent may call: build, verify, explain, measure, render. Each call is a run of the program.
#pragma once

#include <string>
#include <vector>

#include "cli/commands.h"
#include "core/context.h"
#include "core/files.h"
#include "core/process.h"

namespace partscribe::cli {

/// What calls run with.
struct Workshop {
  Path program;  ///< partscribe
  Path root;     ///< canonical; calls see no other folder, and start in it
  ProcessLimits limits;
};

/// The tools as `tools/list` answers them, with schemas made from what the commands declare.
std::string tool_list();

/// The result of a call, `arguments` a JSON object: text and pictures for the agent, and what the command says with
/// --json. What is wrong with the arguments or the files is a result with `isError`.
std::string call_tool(const std::string& tool, const std::string& arguments, const Workshop& workshop,
                      Context& context);

}  // namespace partscribe::cli
