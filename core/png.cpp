#include "core/png.h"

#include <png.h>

#include <bit>
#include <csetjmp>

#include "core/ensure.h"

namespace partscribe::core {
namespace {

void append_bytes(png_structp png, png_bytep bytes, std::size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), count);
}

/// `rows` may hold numbers of the machine's own byte order.
std::string write_rows(int width, int height, int bits, int color, std::size_t row_bytes, const png_byte* rows) {
  std::string out;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  ensure(png, "libpng matches its header");
  png_infop info = png_create_info_struct(png);
  ensure(info, "libpng has memory for a header");
  const bool failed = setjmp(png_jmpbuf(png));
  ensure(!failed, "a picture in memory can be written");
  png_set_write_fn(png, &out, append_bytes, [](png_structp) {});
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), bits, color,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(png, bits == 16 ? 6 : 9);
  png_write_info(png, info);
  if (bits == 16 && std::endian::native == std::endian::little) png_set_swap(png);
  for (int r = 0; r < height; ++r) png_write_row(png, rows + static_cast<std::size_t>(r) * row_bytes);
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return out;
}

}  // namespace

std::string write_png_rgb(int width, int height, std::span<const std::uint8_t> bytes) {
  const std::size_t row = 3 * static_cast<std::size_t>(width);
  ensure(bytes.size() == row * static_cast<std::size_t>(height), "a picture has three bytes for each pixel");
  return write_rows(width, height, 8, PNG_COLOR_TYPE_RGB, row, bytes.data());
}

std::string write_png_grey16(int width, int height, std::span<const std::uint16_t> values) {
  ensure(values.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
         "a picture has a value for each pixel");
  return write_rows(width, height, 16, PNG_COLOR_TYPE_GRAY, 2 * static_cast<std::size_t>(width),
                    reinterpret_cast<const png_byte*>(values.data()));
}

}  // namespace partscribe::core
