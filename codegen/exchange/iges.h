/// Writes a model as IGES 5.3: the exact body and, where every object allows it, the CSG tree that made it.
#pragma once

#include "codegen/backend.h"

namespace partscribe::codegen {

/// A solid travels as a 186 with named and coloured faces, an open sheet as trimmed faces. The boolean tree (or the
/// one primitive) of entities 150-184 stands beside it in the same frame.
Result<Artifact> emit_iges(const CheckedModel& model, const EmitOptions& options, Context& context);

Backend iges_backend();

}  // namespace partscribe::codegen
