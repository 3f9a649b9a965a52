/// Tells when nothing is wrong with a part but its place, size, unit or hand.
#pragma once

#include <optional>
#include <string>

#include "verify/compare/source.h"
#include "verify/verify.h"

namespace partscribe::verify {

/// "the whole part is moved by (0.4, 0, 0) mm: put back, 99.7 % of the points lie on it, now 78 %". Seeks a motion, a
/// change of scale or a mirror that brings the scanned points onto the mesh; nothing where none does so clearly better
/// than leaving it alone. Only ever a remark: what is compared stays where it is.
std::optional<std::string> misplacement(const ScanSource& source, const TriangleMesh& mesh, const MeshDistance& surface,
                                        const VerifyOptions& options, Context& context);

}  // namespace partscribe::verify
