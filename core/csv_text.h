/// Text as a cell of a sheet (RFC 4180).
#pragma once

#include <string>

#include "core/layers.h"

namespace partscribe::core {

/// In quotes if it holds what separates cells or rows.
std::string quoted_csv(const std::string& text);

}  // namespace partscribe::core
