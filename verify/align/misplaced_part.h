/// Tells when nothing is wrong with a part but its place, size, unit or hand.
#pragma once

#include <optional>
#include <string>

#include "verify/compare/source.h"
#include "verify/verify.h"

namespace partscribe::verify {

/// "the whole part is moved by (0.4, 0, 0) mm: put back, 99.7 % of the points lie on it, now 78 %". Looks for a motion,
/// a change of scale or a reflection that brings the scanned points onto the mesh; nothing if none fits clearly better
/// than the scan as it lies. This is a remark only: the scan that is compared stays where it is.
std::optional<std::string> misplacement(const ScanSource& source, const TriangleMesh& mesh, const MeshDistance& surface,
                                        const VerifyOptions& options, Context& context);

}  // namespace partscribe::verify
