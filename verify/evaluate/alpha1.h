/// Runs an Alpha_1 procedure with our own interpreter, which knows the text and nothing else.
#pragma once

#include "verify/exchange/read_brep.h"

namespace partscribe::verify {

inline constexpr const char* scl_interpreter = "partscribe scl interpreter";

/// Parses and executes the .scl file at `path` (and what it includes) and meshes the objects it makes: those of the
/// last dumpGeomFile, dumpA1File or saveModel, else of the last show, else the last labelled one. A text that is
/// refused is `failed` with complaints "file:line:column: ..."; a file that cannot be read is an error. In this
/// process: evaluate_alpha1 (run_occt.h) limits its time and memory, and outlives a crash of OpenCASCADE, which does
/// the booleans.
Result<BrepReading> read_alpha1(const Path& path, const EvaluateOptions& options);

}  // namespace partscribe::verify
