/// Reads and writes 16-bit grey images through libpng; PGM by hand.
#include "scan/read/range_file.h"

#include <png.h>

#include <algorithm>
#include <charconv>
#include <csetjmp>
#include <cstring>

#include "core/ensure.h"
#include "core/png.h"
#include "scan/read/npy.h"

namespace partscribe::scan {
namespace {

constexpr int largest_side = 65535;

struct Source {
  const char* at;
  std::size_t left;
};

void read_bytes(png_structp png, png_bytep to, png_size_t count) {
  auto& source = *static_cast<Source*>(png_get_io_ptr(png));
  if (count > source.left) png_error(png, "the file ends early");
  std::memcpy(to, source.at, count);
  source.at += count, source.left -= count;
}

void keep_message(png_structp png, png_const_charp message) {
  auto* text = static_cast<char*>(png_get_error_ptr(png));
  std::strncpy(text, message, 99);
  png_longjmp(png, 1);
}

void no_warning(png_structp, png_const_charp) {}

/// Nothing with a destructor may live between setjmp and libpng's calls: what grows is owned by the caller.
struct PngData {
  RangeCodes image;
  std::vector<png_bytep> rows;
  char message[100] = {};
  std::string refusal;
};

bool decode(Source& source, std::size_t file_size, PngData& data) {
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, data.message, keep_message, no_warning);
  ensure(png, "libpng must match its header");
  png_infop info = png_create_info_struct(png);
  ensure(info, "libpng must have memory for a header");
  if (setjmp(png_jmpbuf(png))) {
    png_destroy_read_struct(&png, &info, nullptr);
    return false;
  }
  png_set_user_limits(png, largest_side, largest_side);
  png_set_read_fn(png, &source, read_bytes);
  png_read_info(png, info);
  const auto width = png_get_image_width(png, info), height = png_get_image_height(png, info);
  const int depth = png_get_bit_depth(png, info), type = png_get_color_type(png, info);
  if (depth != 16 || type != PNG_COLOR_TYPE_GRAY) {
    png_destroy_read_struct(&png, &info, nullptr);
    data.refusal = "a 16-bit grey image, found " + std::to_string(depth) + " bits" +
                   (type == PNG_COLOR_TYPE_GRAY ? " of grey" : " in colour or with transparency");
    return true;
  }
  // Deflate never shrinks more than 1032 times; a larger claim would only take our memory.
  if (std::uint64_t(width) * height * 2 / 1032 > file_size) {
    png_destroy_read_struct(&png, &info, nullptr);
    data.refusal = "an image that fits its size, found " + std::to_string(width) + " x " + std::to_string(height) +
                   " in " + std::to_string(file_size) + " bytes";
    return true;
  }
  data.image.width = static_cast<int>(width), data.image.height = static_cast<int>(height);
  data.image.codes.resize(std::size_t(width) * height);
  data.rows.resize(height);
  for (std::size_t r = 0; r < height; ++r)
    data.rows[r] = reinterpret_cast<png_bytep>(data.image.codes.data() + r * width);
  png_set_swap(png);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  png_read_image(png, data.rows.data());
  png_read_end(png, nullptr);
  png_destroy_read_struct(&png, &info, nullptr);
  return true;
}

Result<RangeCodes> parse_png(std::string_view bytes, const std::string& name) {
  PngData data;
  Source source{bytes.data(), bytes.size()};
  if (!decode(source, bytes.size(), data))
    return bad_input(name + ": expected a whole PNG image, found damage (" + data.message + ")");
  if (!data.refusal.empty()) return bad_input(name + ": expected " + data.refusal);
  return std::move(data.image);
}

Result<RangeCodes> parse_pgm(std::string_view bytes, const std::string& name) {
  const bool text = bytes[1] == '2';
  std::size_t at = 2;
  const auto space = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
  const auto number = [&](int& value) {
    while (at < bytes.size() && (space(bytes[at]) || bytes[at] == '#')) {
      if (bytes[at] == '#')
        while (at < bytes.size() && bytes[at] != '\n') ++at;
      else
        ++at;
    }
    const auto [end, failure] = std::from_chars(bytes.data() + at, bytes.data() + bytes.size(), value);
    at = static_cast<std::size_t>(end - bytes.data());
    return failure == std::errc() && value >= 0;
  };
  RangeCodes image;
  int most = 0;
  if (!number(image.width) || !number(image.height) || !number(most) || image.width < 1 || image.height < 1 ||
      image.width > largest_side || image.height > largest_side)
    return bad_input(name + ": expected width, height and largest value of a PGM image, found others");
  if (most < 256 || most > 65535)
    return bad_input(name + ": expected a 16-bit image (largest value 256 to 65535), found " + std::to_string(most));
  ++at;
  const std::size_t count = std::size_t(image.width) * static_cast<std::size_t>(image.height);
  const std::size_t room = at < bytes.size() ? (bytes.size() - at + (text ? 1 : 0)) / 2 : 0;
  if (count > room)
    return bad_input(name + ": expected " + std::to_string(count) + " pixels, found room for " + std::to_string(room));
  image.codes.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    int value = 0;
    if (text) {
      if (!number(value) || value > most)
        return bad_input(name + ": expected " + std::to_string(count) + " pixels, found " + std::to_string(i));
    } else {
      value = static_cast<unsigned char>(bytes[at + 2 * i]) << 8 | static_cast<unsigned char>(bytes[at + 2 * i + 1]);
    }
    image.codes[i] = static_cast<std::uint16_t>(value);
  }
  return image;
}

}  // namespace

bool is_range_file(std::string_view suffix) { return suffix == ".png" || suffix == ".pgm" || suffix == ".npy"; }

Result<RangeCodes> parse_range_file(std::string_view bytes, const std::string& name) {
  if (bytes.substr(0, 4) == "\x89PNG") return parse_png(bytes, name);
  if (bytes.size() > 3 && (bytes.substr(0, 2) == "P5" || bytes.substr(0, 2) == "P2")) return parse_pgm(bytes, name);
  if (bytes.substr(0, 6) == "\x93NUMPY") return parse_npy(bytes, name);
  return bad_input(name + ": expected a 16-bit grey PNG or PGM image or a numpy array, found something else");
}

std::string write_png(const RangeCodes& image) { return write_png_grey16(image.width, image.height, image.codes); }

}  // namespace partscribe::scan
