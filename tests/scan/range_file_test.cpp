/// Range images as files.
#include <catch2/catch.hpp>

#include "core/random.h"
#include "scan/range_file.h"

using namespace partscribe;

namespace {

RangeCodes some_codes() {
  RangeCodes image{37, 21, {}};
  Random random(2);
  for (int i = 0; i < 37 * 21; ++i) image.codes.push_back(static_cast<std::uint16_t>(random.below(65536)));
  return image;
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
      {"GIF89a", "expected a 16-bit grey PNG or PGM image, found something else"}};
  for (const auto& [file, message] : bad) {
    const auto result = parse_range_file(file, "bad.png");
    REQUIRE(!result.ok());
    CHECK_THAT(result.error().message, Catch::Contains(message));
  }
}
