/// Completion of the command line by shells: scripts made from what the commands declare.
#pragma once

#include <string>

#include "cli/manual.h"
#include "core/result.h"

namespace partscribe::cli {

/// The script for "bash", "zsh" or "fish"; another shell is a usage error.
Result<std::string> completion(const Manual& manual, const std::string& shell);

}  // namespace partscribe::cli
