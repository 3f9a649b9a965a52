/// Runs another program with limits on what it may use.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/context.h"
#include "core/files.h"
#include "core/result.h"

namespace partscribe::core {

struct ProcessLimits {
  double seconds = 600;      ///< wall time; the whole process group is killed after it
  double memory_mb = 16384;  ///< address space of each process
  double file_mb = 8192;     ///< size of any file that it writes
  int processes = 256;       ///< more than run now; the system does not hold root to it
  double output_mb = 1;      ///< of each of its outputs that is kept: the last of it
};

/// Hears what a program says on standard error, a line at a time, while it runs.
using LineListener = std::function<void(const std::string& line)>;

struct ProcessOutput {
  int exit_code = 0;  ///< 128 + signal when killed by one
  bool timed_out = false;
  std::string out, err;  ///< the end of each
  double seconds = 0;    ///< wall time
};

/// Full path of a program found on PATH; empty if there is none.
Path find_program(const std::string& name);

/// Starts `arguments[0]` (a path or a name on PATH) without a shell and waits for it. It gets no standard input, no
/// other descriptors than the pipes of its output, and of the environment only what programs need to find their files;
/// it ends when this program does. What it started itself and left running is killed. Errors: missing_program if it
/// cannot be started, stopped if the context is cancelled.
Result<ProcessOutput> run_process(const std::vector<std::string>& arguments, const ProcessLimits& limits,
                                  Context& context, const Path& working_directory = {},
                                  const LineListener& listener = {});

/// What a confined program sees beside the system's own programs, libraries and fonts, as absolute paths.
struct Confinement {
  std::vector<Path> readable;  ///< files and folders
  std::vector<Path> writable;  ///< folders for its files alone, whose size is limited
  std::vector<Path> shared;    ///< folders that it may write to as well, and that hold files of others; it starts in
                               ///< the first of these, else in the first writable one
};

/// Why programs cannot be confined on this system, in words; empty if they are.
const std::string& no_confinement();

/// As run_process, without network and without any file but those of `confinement`: by bubblewrap. Where that is not
/// possible (no_confinement()) the program runs with the limits alone, and context.say() says so. Errors: as
/// run_process; stopped if there is hardly any room left in a writable folder.
Result<ProcessOutput> run_confined(const std::vector<std::string>& arguments, const ProcessLimits& limits,
                                   const Confinement& confinement, Context& context, const LineListener& listener = {});

}  // namespace partscribe::core
