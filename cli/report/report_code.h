/// Source text as coloured HTML, so that a page needs no program to colour it.
#pragma once

#include <string>
#include <string_view>

namespace partscribe {

enum class CodeLanguage { openscad, scl };

/// Spans of class c (comment), s (string), n (number), k (keyword) and f (a name before a bracket) around escaped text.
std::string highlighted(std::string_view code, CodeLanguage language);

}  // namespace partscribe
