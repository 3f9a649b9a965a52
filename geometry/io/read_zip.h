/// The files inside a ZIP archive.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace partscribe::geometry::formats {

struct ZippedFile {
  std::string name;
  std::string bytes;
};

/// The files of an archive whose names are `wanted`, unpacked, in the archive's order; `archive` names it in messages.
Result<std::vector<ZippedFile>> unzip(std::string_view bytes, const std::string& archive,
                                      const std::function<bool(const std::string&)>& wanted);

}  // namespace partscribe::geometry::formats
