/// What `build --json` prints: the verdict, and what was found and written.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/commands/wider.h"
#include "core/files.h"
#include "model/model.h"

namespace partscribe::cli {

/// The word for a model's procedure, as --procedure takes it.
std::string procedure_of(const Model& model);

/// The keys of `verdict_json` and, of the model: procedure, its parameters as in model.json, the files, the warnings.
/// `asked`: the only procedure that was allowed; may be empty. `wider`: what to try instead.
std::string build_json(const Model& model, const std::string& asked, const std::optional<Wider>& wider,
                       const std::string& verdict_json, const std::vector<Path>& files,
                       const std::vector<std::string>& warnings);

}  // namespace partscribe::cli
