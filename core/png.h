/// Pictures as PNG files, in memory.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "core/layers.h"

namespace partscribe::core {

/// Red, green and blue of each pixel, row by row from the top.
std::string write_png_rgb(int width_px, int height_px, std::span<const std::uint8_t> bytes);

/// One grey value of 16 bits for each pixel, row by row from the top.
std::string write_png_grey16(int width_px, int height_px, std::span<const std::uint16_t> values);

}  // namespace partscribe::core
