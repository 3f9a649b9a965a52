/// Ranks and robust means against sorted lists and sums by hand.
#include "core/statistics.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "core/random.h"

using namespace partscribe::core;

TEST_CASE("median: the middle of an odd number, the upper middle of an even one, 0 of none") {
  CHECK(median({3, 1, 2}) == 2);
  CHECK(median({4, 1, 3, 2}) == 3);
  CHECK(median({7}) == 7);
  CHECK(median({}) == 0);
}

TEST_CASE("median: values and a list in place agree with the sorted list") {
  Random random(3);
  for (std::size_t count = 1; count < 60; ++count) {
    std::vector<double> values(count);
    for (auto& v : values) v = random.normal();
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    CHECK(median(values) == sorted[count / 2]);
    for (const double share : {0.0, 0.02, 0.5, 0.98, 1.0})
      CHECK(quantile(values, share) == sorted[static_cast<std::size_t>(share * double(count - 1))]);
    CHECK(median_in_place(values) == sorted[count / 2]);
    CHECK(std::is_permutation(values.begin(), values.end(), sorted.begin()));
  }
}

TEST_CASE("quantile: the ends are the least and the largest value, 0 of none") {
  CHECK(quantile({5, 9, 2, 7}, 0) == 2);
  CHECK(quantile({5, 9, 2, 7}, 1) == 9);
  CHECK(quantile({}, 0.5) == 0);
}

TEST_CASE("robust mean: a fifth of wild values moves neither mean nor spread far") {
  Random random(5);
  std::vector<double> values;
  for (int i = 0; i < 4000; ++i) values.push_back(3 + 0.1 * random.normal());
  const RobustMean clean = robust_mean(values);
  CHECK(clean.mean == Approx(3).margin(0.006));
  CHECK(clean.spread == Approx(0.1).epsilon(0.06));
  for (int i = 0; i < 1000; ++i) values.push_back(random.uniform(5, 50));
  const RobustMean spoiled = robust_mean(values);
  CHECK(spoiled.mean == Approx(3).margin(0.03));
  CHECK(spoiled.spread < 0.2);
}

TEST_CASE("robust mean: equal values are their own mean, none are zero") {
  const std::vector<double> equal(9, 0.25);
  CHECK(robust_mean(equal).mean == 0.25);
  CHECK(robust_mean(equal).spread == 0);
  CHECK(robust_mean({}).mean == 0);
}
