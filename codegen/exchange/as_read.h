/// What a program finds in the files that are written of a body.
#pragma once

#include <optional>
#include <vector>

class TopoDS_Shape;

namespace partscribe::codegen {

/// The body written as STEP and as IGES and read again. Files keep one tolerance for all and no curves in the
/// parameters of surfaces: readers find these anew, and what they find need not be as valid as what was written.
/// Nothing if a file cannot be written or read.
std::optional<std::vector<TopoDS_Shape>> as_read(const TopoDS_Shape& body);

}  // namespace partscribe::codegen
