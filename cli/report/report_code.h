/// Source text as coloured HTML, so that a page needs no program to colour it.
#pragma once

#include <string>
#include <string_view>

#include "codegen/backend.h"

namespace partscribe::cli {

/// Spans of class c (comment), s (string), n (number), k (keyword) and f (a name before a bracket) around escaped text.
std::string highlighted(std::string_view code, const Language& language);

}  // namespace partscribe::cli
