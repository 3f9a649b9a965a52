/// Writes a model as an OpenSCAD script (2021.01 or later) and, where it needs one, the library beside it.
#pragma once

#include "codegen/backend.h"

namespace partscribe::codegen {

Result<Artifact> emit_openscad(const CheckedModel& model, const EmitOptions& options, Context& context);

Backend openscad_backend();

}  // namespace partscribe::codegen
