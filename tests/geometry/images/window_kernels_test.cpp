#include "geometry/images/window_kernels.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "core/random.h"
#include "geometry/images/trimmed_window.h"

using namespace partscribe::geometry;

namespace {

struct Line {
  float value, slope, variance, accepted, middle;
};

Line line_of(std::array<float, 5> z, float sigma) {
  std::array<const float*, 5> samples{};
  for (std::size_t k = 0; k < 5; ++k) samples[k] = &z[k];
  Line line{};
  trimmed_lines(samples, &sigma, 1, {&line.value, &line.slope, &line.variance, &line.accepted, &line.middle});
  return line;
}

}  // namespace

TEST_CASE("trimmed lines: two wild samples of five change nothing, wherever they are, three do") {
  Random random(3);
  for (int a = 0; a < 5; ++a)
    for (int b = a + 1; b < 5; ++b) {
      std::array<float, 5> z{};
      for (int k = 0; k < 5; ++k) z[static_cast<std::size_t>(k)] = static_cast<float>(100 + 3 * (k - 2));
      z[static_cast<std::size_t>(a)] += static_cast<float>(random.uniform(500, 900));
      z[static_cast<std::size_t>(b)] -= static_cast<float>(random.uniform(1500, 4000));
      const Line line = line_of(z, 1);
      CHECK(line.value == Approx(100).margin(1e-3));
      CHECK(line.slope == Approx(3).margin(1e-3));
      CHECK(line.accepted == 3);
      CHECK(line.middle == (a == 2 || b == 2 ? 0 : 1));
    }
  // Three wild ones in a line of their own win.
  CHECK(std::abs(line_of({1000, 1010, 1020, 106, 109}, 1).value - 100) > 500);
}

TEST_CASE("trimmed lines: the value has the variance that is stated, but for what the choice of samples adds") {
  Random random(4);
  double squares = 0, stated = 0;
  const int count = 20000;
  for (int n = 0; n < count; ++n) {
    std::array<float, 5> z{};
    for (float& v : z) v = static_cast<float>(random.normal());
    const Line line = line_of(z, 1);
    squares += line.value * line.value / count, stated += line.variance / count;
  }
  CHECK(squares == Approx(stated).epsilon(0.22));
  CHECK(stated < 0.25);
}

TEST_CASE("trimmed lines: fewer than three samples are no line") {
  const float none = std::numeric_limits<float>::quiet_NaN();
  const Line line = line_of({none, 5, none, none, 7}, 1);
  CHECK(line.accepted == 0);
  CHECK(line.middle == 0);
  CHECK(std::isnan(line.value));
  CHECK(line_of({none, 5, 6, none, 8}, 1).accepted == 3);
  // Nor are three that lie on none.
  CHECK(line_of({none, none, -27, 0.5F, 1}, 1).accepted == 0);
  CHECK(line_of({none, none, -2, 0.5F, 1}, 1).accepted == 3);
}

TEST_CASE("trimmed lines: many at once and one at a time give the same bits") {
  Random random(5);
  std::array<std::vector<float>, 5> z;
  for (auto& v : z)
    for (int n = 0; n < 29; ++n) v.push_back(static_cast<float>(random.normal()));
  const std::vector<float> sigma(29, 0.3F);
  std::array<const float*, 5> samples{};
  for (std::size_t k = 0; k < 5; ++k) samples[k] = z[k].data();
  std::vector<float> value(29), slope(29), variance(29), accepted(29), middle(29);
  trimmed_lines(samples, sigma.data(), 29,
                {value.data(), slope.data(), variance.data(), accepted.data(), middle.data()});
  for (std::size_t n = 0; n < 29; ++n) {
    const Line line = line_of({z[0][n], z[1][n], z[2][n], z[3][n], z[4][n]}, 0.3F);
    CHECK(line.value == value[n]);
    CHECK(line.accepted == accepted[n]);
  }
}

TEST_CASE("split windows: the side of the middle is found for a step between any two columns") {
  for (const int step : {-1, 0, 1}) {  // the last column of the near side, or the first if the middle lies right of it
    Window u{}, w{};
    for (int k = 0; k < 25; ++k) {
      const int x = k % 5 - 2;
      const bool near = step >= 0 ? x <= step : x >= 0;
      u[static_cast<std::size_t>(k)] = near ? 0.1F * static_cast<float>(x) : 40, w[static_cast<std::size_t>(k)] = 1;
    }
    Sides sides;
    split_window(u, w, sides);
    const auto best =
        static_cast<std::size_t>(std::min_element(sides.cost.begin(), sides.cost.end()) - sides.cost.begin());
    CHECK(sides.cost[best] < 0.01);
    CHECK(sides.value[best] == Approx(0).margin(1e-4));
    CHECK(sides.slope_x[best] == Approx(0.1).margin(1e-3));
  }
}

TEST_CASE("trimmed windows: ten wild samples of 25 change nothing, thirteen on a plane of their own do") {
  Random random(6);
  Window u{}, w{};
  w.fill(1);
  for (int wild : {10, 13}) {
    for (int k = 0; k < 25; ++k) {
      const auto x = static_cast<float>(k % 5 - 2);
      const bool is_wild = k / 5 < 2 || (wild == 13 && k / 5 == 2 && k % 5 != 2 && k % 5 != 4);
      u[static_cast<std::size_t>(k)] = is_wild ? 300 : 2 * x;
    }
    const TrimmedWindow t = trimmed_window(u, w, false);
    CHECK((std::abs(t.facet.value) < 1e-3) == (wild == 10));
    if (wild == 10) CHECK(t.middle);
  }
}
