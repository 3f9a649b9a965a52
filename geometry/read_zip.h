/// The files inside a ZIP archive.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace partscribe::formats {

struct ZipEntry {
  std::string name;
  std::size_t method = 0, packed = 0, size = 0, offset = 0;  ///< bytes; offset of the local header
};

/// The central directory of an archive; `archive` names it in messages.
Result<std::vector<ZipEntry>> list_zip(std::string_view bytes, const std::string& archive);

/// The bytes of one entry, stored or deflated.
Result<std::string> unzip(std::string_view bytes, const ZipEntry& entry, const std::string& archive);

}  // namespace partscribe::formats
