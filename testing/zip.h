/// ZIP archives made in memory, for readers of archives.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace partscribe::testing {

/// An archive of files by name and content, stored as they are or deflated.
std::string zip(const std::vector<std::pair<std::string, std::string>>& files, bool deflate_them);

}  // namespace partscribe::testing
