/// Range images as files.
#include "scan/read/range_file.h"

#include <catch2/catch.hpp>
#include <limits>

#include "core/random.h"

using namespace partscribe::scan;

namespace {

RangeCodes some_codes() {
  RangeCodes image{37, 21, {}};
  Random random(2);
  for (int i = 0; i < 37 * 21; ++i) image.codes.push_back(static_cast<std::uint16_t>(random.below(65536)));
  return image;
}

/// A file of numpy, format 1.
template <class T>
std::string npy(const std::string& kind, const std::string& shape, const std::vector<T>& numbers) {
  std::string header = "{'descr': '" + kind + "', 'fortran_order': False, 'shape': " + shape + ", }";
  header.resize(117, ' ');
  header += '\n';
  return std::string("\x93NUMPY\1\0", 8) + char(header.size()) + '\0' + header +
         std::string(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T));
}

}  // namespace

TEST_CASE("range file: a 16-bit PNG reads back equal, and the same codes give the same bytes") {
  const auto image = some_codes();
  const auto bytes = write_png(image);
  const auto back = parse_range_file(bytes, "a.png");
  REQUIRE(back.ok());
  CHECK(back->width == 37);
  CHECK(back->height == 21);
  CHECK(back->codes == image.codes);
  CHECK(write_png(image) == bytes);
}

TEST_CASE("range file: PGM, binary and text, is read with its high byte first") {
  const auto binary = parse_range_file("P5\n# made by hand\n2 1\n65535\n" + std::string("\x12\x34\0\5", 4), "a.pgm");
  REQUIRE(binary.ok());
  CHECK(binary->codes == std::vector<std::uint16_t>{0x1234, 5});
  const auto text = parse_range_file("P2 2 1 4095 4660 5", "a.pgm");
  CHECK(!text.ok());
  const auto fitting = parse_range_file("P2 2 1 4095 466 5", "a.pgm");
  REQUIRE(fitting.ok());
  CHECK(fitting->codes == std::vector<std::uint16_t>{466, 5});
}

TEST_CASE("range file: depths of numpy come back within half a step, and what is none did not return") {
  const float none = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> depths = {0.91f, 0.95f, none, 0.992f, 0, -1, 0.93f, 1e6f};
  const auto image = parse_range_file(npy("<f4", "(2, 4)", depths), "depth.npy");
  REQUIRE(image.ok());
  CHECK(image->width == 4);
  CHECK(image->height == 2);
  REQUIRE(image->depth);
  CHECK(image->depth->q < 2e-6);
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (!(depths[i] > 0 && depths[i] < 10))
      CHECK(image->codes[i] == 0);
    else
      CHECK(std::abs(image->depth->z0 + image->depth->q * (image->codes[i] - 1) - depths[i]) < 0.51 * image->depth->q);
  }
  const auto doubles = parse_range_file(npy<double>("<f8", "(1, 2)", {2, 2}), "flat.npy");
  REQUIRE(doubles.ok());
  CHECK(doubles->depth->z0 == 2);
  CHECK(doubles->codes == std::vector<std::uint16_t>{1, 1});
  const auto codes = parse_range_file(npy<std::uint16_t>("<u2", "(1, 3)", {0, 7, 65535}), "codes.npy");
  REQUIRE(codes.ok());
  CHECK(!codes->depth);
  CHECK(codes->codes == std::vector<std::uint16_t>{0, 7, 65535});
}

TEST_CASE("range file: images that cannot be used are refused in one line") {
  const auto bytes = write_png(some_codes());
  auto damaged = bytes;
  damaged[damaged.size() / 2] ^= 1;
  auto huge = bytes;
  huge[16] = 0, huge[17] = 0, huge[18] = '\x7f', huge[19] = '\xff';
  const std::vector<std::pair<std::string, std::string>> bad = {
      {bytes.substr(0, bytes.size() / 2), "expected a whole PNG image, found damage"},
      {damaged, "expected a whole PNG image, found damage"},
      {huge, "expected a whole PNG image, found damage"},
      {"P5\n4 4\n255\n0123456789abcdef", "expected a 16-bit image (largest value 256 to 65535), found 255"},
      {"P5\n40000 40000\n65535\nshort", "expected 1600000000 pixels, found room for 2"},
      {"P5\nwide 4\n", "expected width, height and largest value of a PGM image"},
      {npy<float>("<f4", "(2, 2)", {1, 2, 3}), "expected 4 numbers, found room for 3"},
      {npy<float>("<f4", "(4,)", {1, 2, 3, 4}), "expected an array of two axes"},
      {npy<float>("<f4", "(-4, 1)", {1, 2, 3, 4}), "expected an array of two axes"},
      {npy<float>("<f4", "(99999999999, 1)", {1}), "expected an array of two axes"},
      {npy<float>("<c8", "(1, 1)", {1, 2}), "expected an array of '<f4', '<f8' or '<u2', found '<c8'"},
      {npy<float>("<f4", "(1, 1)", {1}).substr(0, 60), "expected the header of a numpy array"},
      {"\x93NUMPY", "expected the header of a numpy array"},
      {"GIF89a", "expected a 16-bit grey PNG or PGM image or a numpy array, found something else"}};
  for (const auto& [file, message] : bad) {
    const auto result = parse_range_file(file, "bad.png");
    REQUIRE(!result.ok());
    CHECK_THAT(result.error().message, Catch::Contains(message));
  }
}
