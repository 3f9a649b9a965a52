/// Claims about the hypothesis that most samples support.
#include "core/sample_consensus.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

namespace partscribe::testing {
using namespace core;
namespace {

struct Level {
  double height = 0;
};

}  // namespace

TEST_CASE("consensus: the level that most samples share is found among others, the same one each time") {
  std::vector<double> samples;
  for (int k = 0; k < 60; ++k) samples.push_back(5 + 0.001 * (k % 7));
  for (int k = 0; k < 100; ++k) samples.push_back(0.37 * k);
  const auto find = [&] {
    Random random(1);
    const auto draw = [&](auto offer) { offer({drawn_from(samples, random)}); };
    const auto near = [&](const Level& level, double) {
      return double(std::ranges::count_if(samples, [&](double s) { return std::abs(s - level.height) < 0.01; }));
    };
    return consensus<Level>(50, 0, draw, near);
  };
  const auto found = find();
  REQUIRE(found);
  CHECK(found->hypothesis.height == Approx(5).margin(0.01));
  CHECK(found->support >= 60);
  CHECK(find()->hypothesis.height == found->hypothesis.height);
}

TEST_CASE("consensus: of equal ones the first is taken, and none with too little support") {
  int next = 0;
  const auto draw = [&](auto offer) { offer({double(next++)}); };
  const auto same = [](const Level&, double) { return 3.0; };
  CHECK(consensus<Level>(10, 2, draw, same)->hypothesis.height == 0);
  CHECK_FALSE(consensus<Level>(10, 3, draw, same));
  CHECK_FALSE(consensus<Level>(
      10, 0, [](auto) {}, same));
}

}  // namespace partscribe::testing
