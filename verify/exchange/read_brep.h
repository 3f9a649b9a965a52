/// Reads IGES and STEP by OpenCASCADE's readers, in this process: nothing limits how long a hostile file keeps them.
#pragma once

#include <string>

#include "verify/evaluate/evaluate.h"

namespace partscribe::verify {

/// What came out of a file, in a form that can be handed to another process.
struct BrepReading {
  Evaluation evaluation;  ///< without `exact`
  std::string body;       ///< OpenCASCADE's binary form of the body that `exact` is made from; empty if there is none
};

/// The bodies or faces of an IGES file, meshed with the error measured. Where the file also carries a tree of solid
/// primitives (entities 150-184, 430), the tree is evaluated too and must describe the same body. Must not run on two
/// threads at once: it sets global options of OpenCASCADE, whose IGES reader then corrupts memory. Throws
/// std::bad_alloc if memory runs out, unless OpenCASCADE ends the process before, as it often does.
Result<BrepReading> read_iges(const Path& path, const EvaluateOptions& options);

/// The bodies or faces of a STEP file; all else as for IGES.
Result<BrepReading> read_step(const Path& path, const EvaluateOptions& options);

}  // namespace partscribe::verify
