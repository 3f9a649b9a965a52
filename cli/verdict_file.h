/// Reads verdict.json back, so that a report can be made again from files.
#pragma once

#include <string>

#include "core/result.h"
#include "verify/verify.h"

namespace partscribe::cli {

/// What verdict.json says; meshes and deviations of points are not in it. Errors name `where`.
Result<Verdict> read_verdict_json(const std::string& text, const std::string& where);

}  // namespace partscribe::cli
