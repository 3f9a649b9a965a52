/// Runs an Alpha_1 procedure with our own interpreter, which knows the text and nothing else.
#pragma once

#include "verify/evaluate/evaluate.h"

namespace partscribe::verify {

/// Parses and executes the .scl file at `path` (and what it includes) and meshes the objects it makes: those of the
/// last dumpGeomFile, dumpA1File or saveModel, else of the last show, else the last labelled one. A text that is
/// refused is `failed` with complaints "file:line:column: ..."; a file that cannot be read is an error.
Result<Evaluation> evaluate_alpha1(const Path& path, const EvaluateOptions& options, Context& context);

}  // namespace partscribe::verify
