/// Runs another program with limits on time and memory.
#pragma once

#include <string>
#include <vector>

#include "core/context.h"
#include "core/files.h"
#include "core/result.h"

namespace partscribe {

struct ProcessLimits {
  double seconds = 600;              ///< wall time; the whole process group is killed after it
  double memory_mb = 16384;          ///< address space
};

struct ProcessOutput {
  int exit_code = 0;       ///< 128 + signal when killed by one
  bool timed_out = false;
  std::string out, err;    ///< the last megabyte of each
  double seconds = 0;      ///< wall time
};

/// Full path of a program found on PATH; empty if there is none.
Path find_program(const std::string& name);

/// Starts `arguments[0]` (a path or a name on PATH) without a shell and without standard input, and waits for it.
/// Errors: missing_program if it cannot be started, stopped if the context is cancelled.
Result<ProcessOutput> run_process(const std::vector<std::string>& arguments,
                                  const ProcessLimits& limits, Context& context,
                                  const Path& working_directory = {});

}  // namespace partscribe
