/// Colours of deviations.
#include "cli/pictures/color_scale.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

namespace partscribe::testing {

using namespace cli;

namespace {

constexpr Color white{255, 255, 255}, red{255, 0, 0}, blue{0, 0, 255};

}  // namespace

TEST_CASE("scale: lightness alone tells a deviation beyond the tolerance from one within it") {
  auto lightness = [](Color c) { return 0.2126 * c.red + 0.7152 * c.green + 0.0722 * c.blue; };
  double darkest_within = 255, lightest_beyond = 0;
  for (int k = -100; k <= 100; ++k)
    darkest_within = std::min(darkest_within, lightness(deviation_color(k * 0.001, 0.1)));
  for (int k = 101; k <= 500; ++k)
    for (const int side : {-1, 1})
      lightest_beyond = std::max(lightest_beyond, lightness(deviation_color(side * k * 0.001, 0.1)));
  CHECK(darkest_within > 2 * lightest_beyond);
  CHECK_FALSE(deviation_color(0.09, 0.1) == deviation_color(-0.09, 0.1));
  CHECK_FALSE(deviation_color(0.3, 0.1) == deviation_color(-0.3, 0.1));
}

TEST_CASE("scale: the histogram counts every judged point once") {
  const auto counts = scale_histogram({0.0f, 0.05f, -0.05f, 9.0f, std::nanf("")}, 0.1, 4);
  CHECK(counts == std::vector<std::size_t>{0, 1, 2, 1});
}

}  // namespace partscribe::testing
