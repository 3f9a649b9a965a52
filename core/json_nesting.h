/// JSON texts that would exhaust the stack of whoever takes them apart.
#pragma once

#include <string_view>

#include "core/layers.h"

namespace partscribe::core {

inline constexpr int deepest_json = 200;

/// Whether lists and objects of a JSON text stand in each other deeper than deepest_json. Asked before it is parsed:
/// the parser itself bears any depth, but copies, prints and comparisons of what it returns do not.
bool nested_too_deeply(std::string_view json);

}  // namespace partscribe::core
