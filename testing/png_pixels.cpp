#include "testing/png_pixels.h"

#include <zlib.h>

#include <cstdlib>
#include <stdexcept>

namespace partscribe::testing {
namespace {

std::uint32_t number_at(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < 4; ++k) value = value << 8 | static_cast<unsigned char>(bytes.at(at + k));
  return value;
}

}  // namespace

Pixels decoded_png(const std::string& png) {
  Pixels picture;
  std::string packed;
  int channels = 0;
  for (std::size_t at = 8; at + 12 <= png.size();) {
    const std::size_t length = number_at(png, at);
    const std::string type = png.substr(at + 4, 4);
    if (type == "IHDR") {
      picture.width = static_cast<int>(number_at(png, at + 8)),
      picture.height = static_cast<int>(number_at(png, at + 12));
      channels = png.at(at + 17) == 6 ? 4 : 3;
    }
    if (type == "IDAT") packed += png.substr(at + 8, length);
    at += 12 + length;
  }
  const std::size_t stride = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(channels);
  std::vector<unsigned char> rows((stride + 1) * static_cast<std::size_t>(picture.height));
  uLongf size = static_cast<uLongf>(rows.size());
  if (::uncompress(rows.data(), &size, reinterpret_cast<const Bytef*>(packed.data()),
                   static_cast<uLong>(packed.size())) != Z_OK)
    throw std::runtime_error("the picture is no PNG that can be read");
  std::vector<unsigned char> above(stride, 0), row(stride);
  const auto step = static_cast<std::size_t>(channels);
  for (int y = 0; y < picture.height; ++y) {
    const unsigned char* line = rows.data() + static_cast<std::size_t>(y) * (stride + 1);
    for (std::size_t i = 0; i < stride; ++i) {
      const int a = i >= step ? row[i - step] : 0, b = above[i], c = i >= step ? above[i - step] : 0;
      const int p = a + b - c, pa = std::abs(p - a), pb = std::abs(p - b), pc = std::abs(p - c);
      const int guesses[] = {0, a, b, (a + b) / 2, pa <= pb && pa <= pc ? a : pb <= pc ? b : c};
      row[i] = static_cast<unsigned char>(line[i + 1] + guesses[line[0]]);
    }
    for (std::size_t x = 0; x < static_cast<std::size_t>(picture.width); ++x)
      for (std::size_t k = 0; k < 3; ++k) picture.rgb.push_back(row[x * step + k]);
    above = row;
  }
  return picture;
}

}  // namespace partscribe::testing
