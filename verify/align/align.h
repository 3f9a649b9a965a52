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

/// Best fit: robust least squares of the distances to the surface (Welsch weights), started from the frames as they are
/// and from the 24 ways to map the principal axes of the one onto those of the other. Of equally good fits the one
/// nearest to the scan's given pose is taken, and the remark says how many others there are. A scan that already lies
/// right within a fiftieth of the tolerance is not moved at all.
///
/// Datums (3-2-1): the plane through the scanned points of the artifact's largest flat face is laid onto that face. The
/// largest face at an angle of at least 30 degrees to it fixes the rest of the rotation, a third one the last
/// coordinate. A best fit before that tells which points belong to which face. Errors: an artifact without three such
/// faces, or faces without data.
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
