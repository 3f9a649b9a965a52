/// Cuts the text of an Alpha_1 procedure (SCL) into tokens.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace partscribe::verify {

/// Where something stands in its file; both count from 1.
struct SclPlace {
  int line = 1, column = 1;
};

/// "part.scl:12:5".
std::string print_place(const std::string& file, SclPlace place);

struct SclToken {
  enum class Kind { end, identifier, keyword, integer, real, string, symbol };
  Kind kind = Kind::end;
  SclPlace place;
  std::string text;  ///< as written; a keyword in lower case; a string without its quotes
  std::int64_t integer = 0;
  double real = 0;
};

/// The tokens in order, the last of kind `end`. Comments run from # to the end of the line. `not`, `and`, `or`
/// come out as the symbols they stand for. Errors name file, line and column.
Result<std::vector<SclToken>> scl_tokens(std::string_view text, const std::string& file);

/// The same letters in lower case: names of functions and keywords do not heed case.
std::string lower_case(std::string_view text);

}  // namespace partscribe::verify
