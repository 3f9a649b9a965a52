/// From a checked model to the files of any backend.
#pragma once

#include <string>
#include <vector>

#include "core/context.h"
#include "core/files.h"
#include "core/result.h"
#include "model/artifact.h"
#include "model/check.h"

namespace partscribe {

struct EmitOptions {
  Path templates;             ///< a folder of packs that replaces the built-in ones; empty: built in
  std::string stem = "part";  ///< of the file names
};

/// One backend as the list knows it.
struct Backend {
  std::string name;         ///< "openscad"
  std::string suffix;       ///< ".scad"
  std::string description;  ///< one line for --help
};

/// All backends in order: openscad, alpha1, iges, step.
const std::vector<Backend>& backends();

/// Deterministic: the same model gives the same bytes.
Result<Artifact> emit(const CheckedModel& model, const std::string& backend, const EmitOptions& options,
                      Context& context);

}  // namespace partscribe
