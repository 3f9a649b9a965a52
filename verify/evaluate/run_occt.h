/// Runs OpenCASCADE's readers of IGES and STEP in a process of their own, with limits on time and memory.
#pragma once

#include <optional>
#include <string>

#include "verify/evaluate/evaluate.h"

namespace partscribe::verify {

/// What read_iges and read_step (verify/exchange/read_brep.h) make of the file. The program partscribe is started as
/// `partscribe read-brep ...`; what it writes is read back. A reader that crashes is a refusal of the file, `failed`.
/// Errors: missing_program if there is no such program, stopped if it does not finish within its time and memory.
Result<Evaluation> evaluate_iges(const Path& path, const EvaluateOptions& options, Context& context);
Result<Evaluation> evaluate_step(const Path& path, const EvaluateOptions& options, Context& context);

/// Of the library that reads and writes them: "7.6.3".
std::string occt_version();

/// For the main of the program partscribe: if it was started as the reader, does the work and returns the exit code.
std::optional<int> serve_as_reader(int count, const char* const* arguments);

}  // namespace partscribe::verify
