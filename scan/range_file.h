/// 16-bit grey images as files: PNG and PGM in, PNG out.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace partscribe {

/// The codes of a range image, row by row, before anybody says what they mean.
struct RangeCodes {
  int width = 0, height = 0;
  std::vector<std::uint16_t> codes;
};

/// Reads a 16-bit grey PNG or PGM (P5 or P2); `name` is used in messages.
Result<RangeCodes> parse_range_file(std::string_view bytes, const std::string& name);

/// The same bytes for the same codes always.
std::string write_png(const RangeCodes& image);

}  // namespace partscribe
