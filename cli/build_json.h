/// What `build --json` prints: the verdict, and what was found and written.
#pragma once

#include <string>
#include <vector>

#include "core/files.h"
#include "model/model.h"

namespace partscribe {

/// The keys of `verdict_json` and, of the model: procedure, its parameters as in model.json, the files, the warnings. `asked`: the only
/// procedure that was allowed; may be empty.
std::string build_json(const Model& model, const std::string& asked, const std::string& verdict_json, const std::vector<Path>& files,
                       const std::vector<std::string>& warnings);

}  // namespace partscribe
