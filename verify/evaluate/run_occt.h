/// Runs what works with OpenCASCADE, its readers of IGES and STEP and our interpreter of SCL, in a process of its own,
/// with limits on time and memory.
#pragma once

#include <optional>
#include <string>

#include "verify/evaluate/evaluate.h"

namespace partscribe::verify {

/// What read_iges and read_step (verify/exchange/read_brep.h), and read_alpha1 (alpha1.h), make of the file. The
/// program partscribe is started as `partscribe read-brep ...`; what it writes is read back. A reader that crashes is a
/// refusal of the file, `failed`. It sees the file alone, of procedures, which include others, their folder. Errors:
/// missing_program if there is no such program, stopped if it does not finish within its time and memory.
Result<Evaluation> evaluate_iges(const Path& path, const EvaluateOptions& options, Context& context);
Result<Evaluation> evaluate_step(const Path& path, const EvaluateOptions& options, Context& context);
Result<Evaluation> evaluate_alpha1(const Path& path, const EvaluateOptions& options, Context& context);

/// Of the library that reads and writes them: "7.6.3".
std::string occt_version();

/// For the main of the program partscribe: if it was started as the reader, does the work and returns the exit code.
std::optional<int> serve_as_reader(int count, const char* const* arguments);

}  // namespace partscribe::verify
