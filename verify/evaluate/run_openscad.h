/// Runs a .scad file by OpenSCAD.
#pragma once

#include "verify/evaluate/evaluate.h"

namespace partscribe::verify {

/// Binary STL out, warnings are faults, and the result must bound a solid. Includes resolve beside the file.
Result<Evaluation> evaluate_openscad(const Path& path, const EvaluateOptions& options, Context& context);

}  // namespace partscribe::verify
