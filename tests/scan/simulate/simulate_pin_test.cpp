/// The bundled scan of the pin has the noise of the paper's Cylindrical Pin.
#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "model/json.h"
#include "scan/read/read.h"
#include "scan/simulate/simulate.h"
#include "testing/program.h"

using namespace partscribe::scan;

TEST_CASE("simulate: the bundled pin has 256 x 256 pixels of 16 bits, noise of 4 codes and bit errors of 0.001") {
  using partscribe::testing::bytes_of, partscribe::testing::source_file;
  const auto model = read_model_json(bytes_of(source_file("corpus/pin/model.json")), "pin");
  REQUIRE(model.ok());
  const Surface surface = surface_of(*model);
  Context context;
  std::vector<RangeImage> images;
  REQUIRE(read_scan({source_file("corpus/pin/scan")}, {}, context, &images).ok());
  REQUIRE(images.size() == 6);
  double squares = 0, sum = 0;
  std::size_t facing = 0, returns = 0, far_off = 0, one_bit = 0;
  std::uint16_t highest = 0;
  for (const RangeImage& image : images) {
    CHECK(image.width == 256);
    CHECK(image.height == 256);
    for (int r = 0; r < image.height; ++r)
      for (int c = 0; c < image.width; ++c) {
        const auto code = image.codes[static_cast<std::size_t>(r * image.width + c)];
        if (code == image.invalid_code) continue;
        highest = std::max(highest, code);
        ++returns;
        const Vec3 pixel(image.x0 + c * image.pitch_x, image.y0 + r * image.pitch_y, 0);
        const Vec3 ahead = image.world_from_view.rotation.col(2);
        const auto hit = surface.first_hit(image.world_from_view * pixel, ahead);
        REQUIRE(hit);
        const double cosine = -hit->normal.dot(ahead), truth = 1 + (hit->distance - image.z0) / image.q;
        const double off = code - truth, sigma = 4 / cosine;
        if (std::abs(off) > 6 * sigma) {
          ++far_off;
          // Some flip of one bit brings it back.
          bool back = false;
          for (int b = 0; b < 16; ++b) back = back || std::abs((code ^ (1 << b)) - truth) < 5 * sigma;
          one_bit += back;
        } else if (cosine > 0.5) {
          squares += off * off * cosine * cosine, sum += off * cosine, ++facing;
        }
      }
  }
  REQUIRE(facing > 10000);
  CHECK(highest > 32768);
  CHECK(std::sqrt(squares / double(facing)) == Approx(4).epsilon(0.03));
  CHECK(std::abs(sum / double(facing)) < 0.15);
  CHECK(one_bit == far_off);
  // Flips of bits 6 to 15 stand out everywhere, those of 5 where the surface faces the sensor.
  const double flips = 0.001 * double(returns) * 10.5 / 16;
  CHECK(std::abs(double(far_off) - flips) < 3 * std::sqrt(flips));
}
