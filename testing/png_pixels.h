/// What a PNG file shows.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace partscribe::testing {

struct Pixels {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  ///< rows from the top
};

/// Of an 8-bit RGB or RGBA file. Throws std::runtime_error if it cannot be read, and so ends the test.
Pixels decoded_png(const std::string& png);

}  // namespace partscribe::testing
