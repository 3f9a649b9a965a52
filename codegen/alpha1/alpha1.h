/// Writes a model as an Alpha_1 procedure in SCL and the prelude it includes.
#pragma once

#include "codegen/backend.h"

namespace partscribe::codegen {

/// Files: the procedure (stem.scl) and prelude.scl. The procedure uses constructs that the Alpha_1 manual documents and
/// procedures of the prelude; docs/alpha1.md says which is which.
Result<Artifact> emit_alpha1(const CheckedModel& model, const EmitOptions& options, Context& context);

Backend alpha1_backend();

}  // namespace partscribe::codegen
