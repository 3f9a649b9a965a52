/// Writes a model as STEP AP214: the exact body with names and colours.
#pragma once

#include "codegen/emit.h"

namespace partscribe {

Result<Artifact> emit_step(const CheckedModel& model, const EmitOptions& options, Context& context);

}  // namespace partscribe
