/// Pairs of views by us and by other programs.
#pragma once

#include <string>
#include <vector>

#include "core/files.h"

namespace partscribe::testing {

using namespace core;

/// Prints a table: how often each method is right from starts 5 to 60 degrees off, and how far off it is then. Right is
/// within one degree and 2 % of the radius. Errors of every method are taken apart from the motions that we declare
/// free.
void beside(const Path& folder, const std::vector<std::string>& names);

/// Prints tables: how often each method comes within one degree on one part, by overlap and by start, with partners
/// within 10 and 25 mm, and how far off it is then.
void basin(const Path& scan_json);

}  // namespace partscribe::testing
