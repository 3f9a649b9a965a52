/// Range images as files: PNG, PGM and numpy arrays in, PNG out.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace partscribe::scan {

/// Depth z = z0 + q * (code - 1), in the file's own unit.
struct DepthSteps {
  double z0 = 0, q = 1;
};

/// The codes of a range image, row by row, before anybody says what they mean.
struct RangeCodes {
  int width = 0, height = 0;
  std::vector<std::uint16_t> codes;
  std::optional<DepthSteps> depth = {};  ///< of files that hold depths; code 0 did not return then
};

/// Of suffixes in small letters: ".png", ".pgm", ".npy".
bool is_range_file(std::string_view suffix);

/// Reads a 16-bit grey PNG or PGM (P5 or P2), or an array of numpy (npy.h); `name` is used in messages.
Result<RangeCodes> parse_range_file(std::string_view bytes, const std::string& name);

/// The same bytes for the same codes always.
std::string write_png(const RangeCodes& image);

}  // namespace partscribe::scan
