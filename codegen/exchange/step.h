/// Writes a model as STEP AP214: the exact body with names and colours.
#pragma once

#include "codegen/backend.h"

namespace partscribe::codegen {

Result<Artifact> emit_step(const CheckedModel& model, const EmitOptions& options, Context& context);

Backend step_backend();

}  // namespace partscribe::codegen
