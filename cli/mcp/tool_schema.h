/// The commands' own options as arguments of tools: a JSON schema of them, and what a call gives as words of a command
/// line.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "core/files.h"
#include "core/result.h"

namespace partscribe::cli {

/// "--time-limit" is the property "time_limit"; operands keep their names.
std::string property_name(const Declared& declared);

/// A text that speaks of options, "give --force", in words that an agent can follow: give "force": true.
std::string in_properties(std::string text, const std::vector<Declared>& declared);

/// A JSON schema (draft 2020-12) of an object with one property for each option and operand.
nlohmann::ordered_json input_schema(const std::vector<Declared>& declared);

/// The words that say the same on a command line. Paths are relative to `root` or absolute; one that leads out of it,
/// by links as well, is a usage error, and so is what the schema does not allow. `root` is canonical.
Result<std::vector<std::string>> command_words(const nlohmann::ordered_json& arguments,
                                               const std::vector<Declared>& declared, const Path& root);

}  // namespace partscribe::cli
