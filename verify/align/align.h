/// Finds the rigid motion that lays the scan onto an evaluated artifact. Only ever on request.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/context.h"
#include "core/result.h"
#include "verify/compare/source.h"
#include "verify/verify.h"

namespace partscribe::verify {

/// Best fit: least squares of the distances to the surface (Welsch weights), from the frames as they are and from the
/// 24 ways in which the principal axes can be laid onto each other; of fits that are equally good the nearest to how
/// the scan lies, and the remark says how many others there are. A scan that lies right already, within a fiftieth of
/// the tolerance, is not moved at all.
///
/// Datums (3-2-1): the plane through the scanned points of the artifact's largest flat face is laid onto that face,
/// that of the largest face across to it fixes the rest of the rotation, a third one the last coordinate. Which points
/// belong to which face is known from a best fit before. Errors: an artifact without three such faces, or faces without
/// data.
Result<Alignment> align(const ScanSource& source, const TriangleMesh& mesh, const MeshDistance& surface, AlignBy by,
                        double tolerance, Context& context);

/// Aligns as the options say, moves the verdict's mesh into the scan's frame and notes how.
Result<bool> lay_onto_scan(const ScanSource& source, const VerifyOptions& options, ArtifactVerdict& verdict,
                           Context& context);

/// One line if much of a refused scan is off the artifact, and all of it would pass after a rigid motion.
std::optional<std::string> hint_at_frame(const ScanSource& source, const VerifyOptions& options,
                                         const ArtifactVerdict& verdict, Context& context);

/// "turned by 12.5 degrees and moved by 3.2 mm (3, 1, 0)" or "left where it lies"
std::string words_for(const Alignment& alignment);

}  // namespace partscribe::verify
