/// From a checked model to the files of any backend.
#pragma once

#include <string>
#include <vector>

#include "codegen/backend.h"

namespace partscribe::codegen {

/// All backends in order: openscad, alpha1, iges, step.
const std::vector<Backend>& backends();

/// Deterministic: the same model gives the same bytes.
Result<Artifact> emit(const CheckedModel& model, const std::string& backend, const EmitOptions& options,
                      Context& context);

}  // namespace partscribe::codegen
