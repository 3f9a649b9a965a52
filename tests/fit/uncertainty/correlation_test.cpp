/// Correlation of noise on a grid whose filter is known.
#include "fit/uncertainty/correlation.h"

#include <catch2/catch.hpp>

#include "core/random.h"

using namespace partscribe::fit;

namespace {

constexpr int size = 100;
constexpr double pitch = 0.4;

/// White noise after a mean over `width` x `width` pixels.
std::vector<double> filtered(int width, Random& random) {
  const int wide = size + width - 1;
  std::vector<double> raw(std::size_t(wide * wide)), result;
  for (auto& v : raw) v = random.normal();
  for (int r = 0; r < size; ++r)
    for (int c = 0; c < size; ++c) {
      double sum = 0;
      for (int i = 0; i < width; ++i)
        for (int j = 0; j < width; ++j) sum += raw[std::size_t((r + i) * wide + c + j)];
      result.push_back(sum / (width * width));
    }
  return result;
}

/// `views` grids, each a little aside of the others, in `groups` groups.
Correlation measured(int width, int views, int groups) {
  Random random(17);
  std::vector<Vec3> places;
  std::vector<double> residuals;
  std::vector<int> group;
  for (int v = 0; v < views; ++v) {
    const auto noise = filtered(width, random);
    for (int r = 0; r < size; ++r)
      for (int c = 0; c < size; ++c) {
        places.push_back(pitch * Vec3(c + 0.37 * v, r + 0.29 * v, 0));
        residuals.push_back(noise[std::size_t(r * size + c)]);
        group.push_back(v % groups);
      }
  }
  return correlation_of(places, residuals, group, groups, 2);
}

}  // namespace

TEST_CASE("correlation: white noise is independent and no filter") {
  const Correlation white = measured(1, 1, 1);
  CHECK(white.points_per_independent < 1.1);
  CHECK(white.smoothing == 0);
}

TEST_CASE("correlation: a mean over 3 x 3 pixels leaves one point in nine, and its variance is found") {
  const Correlation mean = measured(3, 1, 1);
  CHECK(mean.points_per_independent == Approx(9).epsilon(0.15));
  CHECK(mean.smoothing == Approx(2.0 / 3 * pitch * pitch).epsilon(0.15));
  CHECK(measured(5, 1, 1).smoothing == Approx(2 * pitch * pitch).epsilon(0.2));
}

TEST_CASE("correlation: views have separate noise") {
  const Correlation apart = measured(3, 3, 3);
  CHECK(apart.points_per_independent == Approx(9).epsilon(0.15));
  CHECK(apart.smoothing == Approx(2.0 / 3 * pitch * pitch).epsilon(0.15));
}
