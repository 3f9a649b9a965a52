/// Reads IGES and STEP by OpenCASCADE's readers.
#pragma once

#include "verify/evaluate.h"

namespace partscribe {

/// The bodies or faces of an IGES file, meshed with the error measured. Where the file also carries a tree of solid
/// primitives (entities 150-184, 430), the tree is evaluated too and must describe the same body.
Result<Evaluation> evaluate_iges(const Path& path, const EvaluateOptions& options, Context& context);

/// The bodies or faces of a STEP file, meshed with the error measured.
Result<Evaluation> evaluate_step(const Path& path, const EvaluateOptions& options, Context& context);

}  // namespace partscribe
