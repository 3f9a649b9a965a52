/// JSON as this product writes it: stable order, two-space indentation, numbers by print_number.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/layers.h"

namespace partscribe::core {

/// Lists of plain values stay on one line; everything ends with a newline. Infinite numbers become null.
std::string json_text(const nlohmann::ordered_json& value);

}  // namespace partscribe::core
