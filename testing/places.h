/// Where the program and the files of the source tree are.
#pragma once

#include <string>

#include "core/files.h"

namespace partscribe::testing {

using namespace core;

/// The program itself.
Path program();

/// A file or folder of the source tree: "docs/model.schema.json".
Path source_file(const std::string& path);

}  // namespace partscribe::testing
